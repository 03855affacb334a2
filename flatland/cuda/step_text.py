"""What a step does in each cell, written out as CUDA C for one stencil.

Symbols inside the text: S source, T target, X accumulated or right-hand side.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from flatland.cuda.parts import (
    LARGEST_BLOCK,
    block_for,
    box_arguments,
    box_size,
    cell_number,
    each,
    gather,
    indented,
    kernel,
    number,
    position,
    preamble,
    summing,
    threads,
)
from flatland.kernels.layout import Layout
from flatland.kernels.orbits import significant
from flatland.stencil import Stencil

#: Multiply-adds of a cell up to which they are written out, with constants; more are loops over a
#: table: a compiler takes seconds for so many, and they do not fit in an instruction cache.
LARGEST_TEXT = 2500
#: Outputs held in registers at once by loops.
_TILE = 16

#: Gives what is done with a value (its place in a field, its name, its component if it is one).
Store = Callable[[str, str, "int | None"], list[str]]


class StepText:
    """Kernels of one stencil on one layout.

    `step` does T = A S, X += T and reports sums of components and of all squares; `combine` does
    T = f₀ S + f₁ X + f₂ (A S), and only reads X. One thread takes a cell, and the next one its
    neighbour along the last axis.

    blocked: τ multiplies what arrives in cells that `walls` has a number for. sums: components
    whose sums are reported.
    """

    def __init__(
        self, stencil: Stencil, layout: Layout, blocked: bool, sums: tuple[int, ...]
    ) -> None:
        self.stencil, self.layout, self.blocked, self.sums = stencil, layout, blocked, sums
        self.transfer = significant(stencil.transfer)
        used = [self.transfer]
        if stencil.clamp:
            assert stencil.reception is not None
            assert stencil.emission is not None
            self.reception = significant(stencil.reception)
            self.emission = significant(stencil.emission)
            used = [self.reception, self.emission]
        #: Whether numbers are read from `table` and not constants.
        self.looped = sum(map(np.count_nonzero, used)) > LARGEST_TEXT
        self.block = block_for(len(sums) + 1)
        self._components = layout.components
        self._padded = -(-layout.components // _TILE) * _TILE

    def stepping(self) -> str:
        """The kernels `step` and `gather`."""
        names = [f"sum_{i}" for i in range(len(self.sums) + 1)]
        arguments = [
            "const real* __restrict__ S",
            "real* __restrict__ T",
            "real* __restrict__ X",
            *self._arguments(),
            "long long row",
            "double* __restrict__ partial",
        ]
        loop = each("q", "cells", self.block, self._cell(self._store))
        body = [box_size(len(self.layout.shape)), *summing(names, self.block, loop)]
        return self._joined([*kernel("step", arguments, body), *gather()])

    def combining(self) -> str:
        """The kernel `combine`."""
        arguments = [
            "const real* __restrict__ S",
            "const real* __restrict__ X",
            "real* __restrict__ T",
            *self._arguments(),
            *(f"double factor_{i}" for i in range(3)),
        ]
        factors = [f"const real f_{i} = (real)factor_{i};" for i in range(3)]
        loop = each("q", "cells", LARGEST_BLOCK, self._cell(self._combination))
        body = [box_size(len(self.layout.shape)), *factors, *threads(LARGEST_BLOCK, loop)]
        return self._joined(kernel("combine", arguments, body))

    @property
    def table(self) -> NDArray[np.float64]:
        """Numbers for the loops, outputs side by side and filled up to whole tiles."""
        if not self.stencil.clamp:
            return self._wide(np.swapaxes(self.transfer, 1, 2)).ravel()
        emission = self._wide(np.swapaxes(self.emission, 1, 2))
        return np.concatenate([self.reception.ravel(), emission.ravel()])

    def _wide(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        wide = np.zeros((*values.shape[:2], self._padded))
        wide[:, :, : self._components] = values
        return wide

    def _joined(self, lines: list[str]) -> str:
        return preamble(self.layout.dtype, self.layout.size) + "\n" + "\n".join(lines)

    def _arguments(self) -> list[str]:
        """Those that both kernels have, see `CudaSweep`."""
        walls = [
            "const int* __restrict__ walls",
            "const real* __restrict__ shares",
            "long long near",
        ]
        table = ["const real* __restrict__ table"]
        return [
            *(walls if self.blocked else []),
            *(table if self.looped else []),
            *box_arguments(len(self.layout.shape)),
        ]

    # -- one cell -------------------------------------------------------------------------------

    def _cell(self, store: Store) -> list[str]:
        lines = position(self.layout)
        if self.blocked:
            lines += [cell_number(self.layout), "const long long wall = walls[cell];"]
        if self.looped:
            return [*lines, *self._tiles(store)]
        lines += [f"real a_{output} = 0;" for output in range(self._components)]
        for d in range(len(self.stencil.offsets)):
            body = self._faces(d) if self.stencil.clamp else self._couplings(d)
            if body:
                lines += ["{", *indented([*self._incoming(d), *body]), "}"]
        for output in range(self._components):
            lines += store(f"at + {output * self.layout.component_stride}", f"a_{output}", output)
        return lines

    def _incoming(self, d: int) -> list[str]:
        """Declares `from`, where what arrives along offset d was, and what walls leave of it."""
        shift = self.layout.shift(self.stencil.offsets[d])
        lines = [f"const real* __restrict__ from = S + (at - ({shift}));"]
        if self.blocked:
            lines.append(f"const real open = wall < 0 ? (real)1 : shares[{d} * near + wall];")
        return lines

    def _light(self, component: str) -> str:
        light = f"from[{component}]"
        return f"open * {light}" if self.blocked else light

    def _read(self, components: Iterable[int]) -> list[str]:
        """Declares light_k for some components of the light that arrives."""
        stride = self.layout.component_stride
        return [f"const real light_{k} = {self._light(str(k * stride))};" for k in components]

    def _couplings(self, d: int) -> list[str]:
        used = self.transfer[d]
        lines = self._read(int(k) for k in np.flatnonzero(used.any(axis=0)))
        for output, k in np.argwhere(used):
            weight = number(used[output, k], self.layout.dtype)
            lines.append(f"a_{output} = FUSED({weight}, light_{k}, a_{output});")
        return lines

    def _faces(self, d: int) -> list[str]:
        """Face fluxes first, negative ones dropped, then the lobes."""
        reception, emission, dtype = self.reception[d], self.emission[d], self.layout.dtype
        lines = self._read(int(k) for k in np.flatnonzero(reception.any(axis=0)))
        for face in np.flatnonzero(reception.any(axis=1)):
            lines.append(f"real face_{face} = 0;")
            for k in np.flatnonzero(reception[face]):
                weight = number(reception[face, k], dtype)
                lines.append(f"face_{face} = FUSED({weight}, light_{k}, face_{face});")
            lines.append(f"face_{face} = LARGER(face_{face}, (real)0);")
            for output in np.flatnonzero(emission[:, face]):
                weight = number(emission[output, face], dtype)
                lines.append(f"a_{output} = FUSED({weight}, face_{face}, a_{output});")
        return lines

    # -- loops ----------------------------------------------------------------------------------

    def _tiles(self, store: Store) -> list[str]:
        """All outputs, some at a time, each from all the light that arrives."""
        stride = self.layout.component_stride
        kept = [
            "const int output = first + o;",
            f"if (output < {self._components}) {{",
            *indented(store(f"at + (place)output * {stride}", "a[o]", None)),
            "}",
        ]
        body = [
            f"real a[{_TILE}];",
            *_unrolled(["a[o] = 0;"]),
            *(line for d in range(len(self.stencil.offsets)) for line in self._looped(d)),
            *_unrolled(kept),
        ]
        return [
            f"for (int first = 0; first < {self._components}; first += {_TILE}) {{",
            *indented(body),
            "}",
        ]

    def _looped(self, d: int) -> list[str]:
        """What arrives along one offset, in a tile of outputs."""
        incoming = self._light(f"(place)k * {self.layout.component_stride}")
        if self.stencil.clamp:
            body = self._looped_faces(d, incoming)
        else:
            row = f"({d * self._components} + k) * {self._padded}"
            body = [
                f"for (int k = 0; k < {self._components}; ++k) {{",
                f"    const real light = {incoming};",
                f"    const real* __restrict__ weights = table + {row} + first;",
                *indented(_unrolled(["a[o] = FUSED(weights[o], light, a[o]);"])),
                "}",
            ]
        return ["{", *indented([*self._incoming(d), *body]), "}"]

    def _looped_faces(self, d: int, incoming: str) -> list[str]:
        faces = self.reception.shape[1]
        face = f"({d * faces} + face) * {self._components}"
        row = f"{self.reception.size} + ({d * faces} + face) * {self._padded}"
        return [
            f"for (int face = 0; face < {faces}; ++face) {{",
            f"    const real* __restrict__ seen = table + {face};",
            f"    const real* __restrict__ weights = table + {row} + first;",
            "    real flux = 0;",
            f"    for (int k = 0; k < {self._components}; ++k)",
            f"        flux = FUSED(seen[k], {incoming}, flux);",
            "    flux = LARGER(flux, (real)0);",
            *indented(_unrolled(["a[o] = FUSED(weights[o], flux, a[o]);"])),
            "}",
        ]

    # -- what becomes of a value ----------------------------------------------------------------

    def _store(self, place: str, value: str, output: int | None) -> list[str]:
        """`step`: output is a component, or None for the variable of that name."""
        lines = [f"T[{place}] = {value};", f"X[{place}] += {value};"]
        for i, component in enumerate(self.sums):
            if output is None:
                lines.append(f"if (output == {component}) sum_{i} += {value};")
            elif output == component:
                lines.append(f"sum_{i} += {value};")
        squares = f"sum_{len(self.sums)}"
        return [*lines, f"{squares} = fma((double){value}, (double){value}, {squares});"]

    def _combination(self, place: str, value: str, output: int | None) -> list[str]:
        inner = f"FUSED(S[{place}], f_0, {value} * f_2)"
        return [f"T[{place}] = FUSED(X[{place}], f_1, {inner});"]


def _unrolled(body: list[str]) -> list[str]:
    """A loop over the outputs of a tile, which a compiler keeps in registers."""
    return ["#pragma unroll", f"for (int o = 0; o < {_TILE}; ++o) {{", *indented(body), "}"]
