"""Light that leaves the grid: border cells, their weights, and the loop that adds them up."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.layout import Layout
from flatland.kernels.orbits import significant
from flatland.stencil import Stencil

#: Sums kept apart in one pass over the border: adding to one waits four cycles for the last time,
#: and in 3D, where one cell in ten lies on the border, that was a quarter of a step.
_SUMS = 8


def border(
    stencil: Stencil, layout: Layout, transmittance: NDArray[np.float64] | None
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Cells from which light leaves the grid, as positions, and how much of each coefficient.

    Weights (M, components): Σ over offsets d that lead outside of τ(x, d) T_d[0, :]. What goes
    through a mirror stays inside.
    """
    ends = np.add(layout.shape, layout.ghosts)
    edge = np.zeros(layout.shape, bool)
    for axis, ghosts in enumerate(layout.ghosts):
        np.moveaxis(edge, axis, 0)[[0] if ghosts else [0, -1]] = True
    places = np.argwhere(edge)
    weights = np.zeros((len(places), layout.components))
    flux = significant(stencil.transfer)[:, 0]
    for d, offset in enumerate(stencil.offsets):
        goal = places + offset
        outside = np.any((goal < 0) | (goal >= ends), axis=1)
        passing = 1.0 if transmittance is None else transmittance[(d, *places[outside].T)][:, None]
        weights[outside] += passing * flux[d]
    return layout.index(places), weights * layout.copies(places)[:, None]


def outflow_text(layout: Layout, weights: NDArray[np.float64]) -> str:
    """Assembly of `outflow(S, cells, weights, first, last)`: Σ weights · light over some cells.

    Coefficients that no border cell sends out are left alone.
    """
    used = [int(k) for k in np.flatnonzero(weights.any(axis=0))]
    lines = [
        "declare double @llvm.fma.f64(double, double, double)",
        "define double @outflow(ptr noalias readonly %S, ptr noalias readonly %cells,",
        "                       ptr noalias readonly %weights, i64 %first, i64 %last) {",
        "entry:",
        "  %any = icmp slt i64 %first, %last",
        "  br label %pass0",
    ]
    total = "0.0"
    for number, first in enumerate(range(0, len(used), _SUMS)):
        lines += _pass(layout, number, used[first : first + _SUMS], total)
        total = f"%total{number}"
    passes = -(-len(used) // _SUMS)
    return "\n".join([*lines, f"pass{passes}:", f"  ret double {total}", "}"]) + "\n"


def _pass(layout: Layout, p: int, components: Sequence[int], total: str) -> list[str]:
    """One loop over the cells; `total` is the sum of the loops before."""
    lines = [
        f"pass{p}:",
        f"  br i1 %any, label %cell{p}, label %done{p}",
        f"cell{p}:",
        f"  %m{p} = phi i64 [%first, %pass{p}], [%next{p}, %cell{p}]",
        *(f"  %old{k} = phi double [0.0, %pass{p}], [%new{k}, %cell{p}]" for k in components),
        f"  %where{p} = getelementptr i64, ptr %cells, i64 %m{p}",
        f"  %index{p} = load i64, ptr %where{p}",
        f"  %row{p} = mul i64 %m{p}, {layout.components}",
    ]
    for k in components:
        lines += _term(layout, p, k)
    lines += [
        f"  %next{p} = add i64 %m{p}, 1",
        f"  %more{p} = icmp slt i64 %next{p}, %last",
        f"  br i1 %more{p}, label %cell{p}, label %done{p}",
        f"done{p}:",
        *(f"  %sum{k} = phi double [0.0, %pass{p}], [%new{k}, %cell{p}]" for k in components),
    ]
    for k in components:
        result = f"%total{p}" if k == components[-1] else f"%up_to{k}"
        lines.append(f"  {result} = fadd double {total}, %sum{k}")
        total = result
    return [*lines, f"  br label %pass{p + 1}"]


def _term(layout: Layout, p: int, k: int) -> list[str]:
    """%new<k> = %old<k> + weight · light of one coefficient of one cell."""
    scalar = "float" if layout.dtype == np.float32 else "double"
    light = f"%light{k}"
    lines = [
        f"  %weight_at{k} = add i64 %row{p}, {k}",
        f"  %weight_pointer{k} = getelementptr double, ptr %weights, i64 %weight_at{k}",
        f"  %weight{k} = load double, ptr %weight_pointer{k}",
        f"  %at{k} = add i64 %index{p}, {k * layout.component_stride}",
        f"  %pointer{k} = getelementptr {scalar}, ptr %S, i64 %at{k}",
        f"  {light} = load {scalar}, ptr %pointer{k}",
    ]
    if scalar == "float":
        lines.append(f"  %wide{k} = fpext float {light} to double")
        light = f"%wide{k}"
    sum_ = f"call double @llvm.fma.f64(double %weight{k}, double {light}, double %old{k})"
    return [*lines, f"  %new{k} = {sum_}"]
