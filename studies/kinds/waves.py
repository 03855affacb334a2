"""What a scheme does to a wave of light: how it fades in a step, and what stays of a source."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from flatland.stencil import Stencil
from studies.kinds.base import SCHEME_COLUMNS, Column, Row
from studies.kinds.radius import OnSymbols, python_command, stencil_of
from studies.sweeps.case import Case

Array = NDArray[np.float64]

#: Waves per direction, from the longest to the shortest that a grid holds.
WAVES = 48
#: Components up to π, beyond which waves repeat, so that diagonal waves are shorter.
DIRECTIONS: dict[str, tuple[float, ...]] = {"axis": (1.0, 0.0, 0.0), "diagonal": (1.0, 1.0, 1.0)}


class Waves(OnSymbols):
    """One row per wave vector k, along an axis and along the diagonal of the grid.

    The step multiplies a wave by its symbol A(k); the eigenvalue of largest modulus is what is
    left after many steps. Accumulated over all steps an isotropic source of that wave leaves
    [(1 − A(k))⁻¹]₀₀ of scalar flux, its response.

    In truth light flies straight, and each cell on its way counts it once. Averaged over
    directions, long waves in 2D answer with (|ω_x| + |ω_y|) / |k| at ω ⊥ k: 1/|k| along an axis,
    √2/|k| along the diagonal. (Fourier transform of rays: only directions along the crests add up.)
    A response that falls faster, like diffusion's 1/k², spreads light too evenly over long
    distances and too little over short ones.
    """

    name = "waves"
    summary = "symbol of a scheme over wave numbers: damping and response to a source"
    columns: ClassVar = {
        "dimension": Column(int, "of the grid"),
        **SCHEME_COLUMNS,
        "direction": Column(str, "of the wave vector: along an axis or a diagonal"),
        "wave": Column(float, "|k|", "rad/cell"),
        "radius": Column(float, "largest modulus of the symbol's eigenvalues"),
        "phase": Column(float, "argument of that eigenvalue, 0 to π", "rad"),
        "response": Column(float, "scalar flux of all steps over that of an isotropic source"),
        "exact_response": Column(float, "what straight flight leaves, for long waves (2D)"),
        "command": Column(str, "what computes the row again"),
    }

    def rows(self, case: Case, references: str) -> Iterator[Row]:
        stencil = stencil_of(case.parameters)
        # Half a step off k = 0, where light that never fades has no finite response.
        sizes = (np.arange(WAVES) + 0.5) * np.pi / WAVES
        for name, direction in DIRECTIONS.items():
            vectors = sizes[:, None] * np.array(direction[: case.parameters["dimension"]])
            for vector, row in zip(vectors, wave_rows(stencil, vectors)):
                shown = f"print(abs(eigvals(stencil.symbol({vector.tolist()}))).max())"
                ending = f"from numpy.linalg import eigvals; {shown}"
                command = python_command(case.parameters, ending)
                yield {"direction": name, **row, "command": command}


def wave_rows(stencil: Stencil, vectors: Array) -> list[Row]:
    """Numbers of each wave vector (K, dimension)."""
    symbols = stencil.symbol(vectors)
    eigenvalues = np.linalg.eigvals(symbols)
    leading = np.take_along_axis(eigenvalues, np.abs(eigenvalues).argmax(axis=1)[:, None], axis=1)[
        :, 0
    ]
    responses = [_response(symbol) for symbol in symbols]
    return [
        {
            "wave": float(np.linalg.norm(vector)),
            "radius": float(abs(value)),
            "phase": float(abs(np.angle(value))),
            "response": response,
            "exact_response": exact_response(vector),
        }
        for vector, value, response in zip(vectors, leading, responses)
    ]


def exact_response(vector: Array) -> float:
    """(|k_x| + |k_y|) / |k|² in 2D, see `Waves`; NaN in 3D."""
    if vector.size != 2:
        return float("nan")
    return float(np.abs(vector).sum() / np.sum(vector**2))


def _response(symbol: NDArray[np.complex128]) -> float:
    """[(1 − A)⁻¹]₀₀, real as isotropic light is its own mirror image; NaN if 1 − A is singular."""
    source = np.eye(len(symbol))[:, 0]
    try:
        return float(np.linalg.solve(np.eye(len(symbol)) - symbol, source)[0].real)
    except np.linalg.LinAlgError:
        return float("nan")
