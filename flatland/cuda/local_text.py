"""CUDA C for what happens in some cells only: light that leaves the grid, and what walls send back.

All in double precision, whatever the fields are in: these are the books, and few cells.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.cuda.parts import (
    LARGEST_BLOCK,
    block_for,
    box_arguments,
    box_size,
    each,
    indented,
    kernel,
    position,
    preamble,
    summing,
    threads,
)
from flatland.kernels.layout import Layout
from flatland.kernels.reflection import sent_rows
from flatland.stencil import Stencil

Array = NDArray[np.float64]

_CELLS = ["const long long* __restrict__ cells_at", "long long cells"]
_FLUX = ["const double* __restrict__ reception", "const double* __restrict__ emission"]
_REPORT = ["long long row", "double* __restrict__ partial"]
_SOURCE = "const real* __restrict__ S"
#: Written out by a compiler, what cells send along 26 offsets took all registers there are.
_ROLLED = "#pragma unroll 1"


class LocalText:
    """Kernels of one stencil on one layout.

    `outflow` reports the flux that goes over the border, `sent` that which all cells send;
    `reflect` adds what comes back to T and X and reports what it changed; `add` adds it, times a
    factor, to T. The flux along an offset is Σ_f emission_f · reception_f · S, over faces if
    negative fluxes are dropped, else of one face that stands for all.
    """

    def __init__(self, stencil: Stencil, layout: Layout, sums: tuple[int, ...]) -> None:
        self.stencil, self.layout, self.sums = stencil, layout, sums
        if stencil.clamp:
            assert stencil.reception is not None
            assert stencil.emission is not None
            self.reception = np.ascontiguousarray(stencil.reception)
            self.emission = np.ascontiguousarray(stencil.emission[:, 0])
        else:
            self.reception = sent_rows(stencil)[:, None]
            self.emission = np.ones((len(stencil.offsets), 1))
        self._offsets, self._faces = self.emission.shape

    def leaving(self) -> str:
        """The kernel `outflow`, and for clamped stencils `sent`, to follow other kernels."""
        if not self.stencil.clamp:
            return "\n".join(self._outflow())
        return "\n".join([*self._flux(), *self._outflow(), *self._sent()])

    def reflecting(self) -> str:
        """The kernels `reflect` and `add`."""
        lines = [*self._flux(), *self._reflect(), *self._add()]
        return preamble(self.layout.dtype, self.layout.size) + "\n" + "\n".join(lines)

    def weights(self, border: Array, passing: Array) -> Array:
        """What `outflow` reads, a row for each of its terms in a border cell, all cells in it.

        border: (M, components), of the stencil. passing: (M, K), the open share of links that lead
        outside, 0 for others.
        """
        values = passing if self.stencil.clamp else border
        return np.ascontiguousarray(values.T)

    def _flux(self) -> list[str]:
        """Device function: flux, in units of coefficient 0, that a cell sends along an offset."""
        count, stride = self.layout.components, self.layout.component_stride
        kept = "fmax(face, 0.0)" if self.stencil.clamp else "face"
        arguments = ", ".join([_SOURCE, "long long at", "int d", *_FLUX])
        return [
            f"DEVICE double flux_along({arguments})",
            "{",
            "    double flux = 0.0;",
            f"    for (int f = d * {self._faces}; f < (d + 1) * {self._faces}; ++f) {{",
            "        double face = 0.0;",
            f"        for (int k = 0; k < {count}; ++k)",
            f"            face = fma(reception[f * {count} + k],",
            f"                       (double)S[at + (long long)k * {stride}], face);",
            f"        flux = fma(emission[f], {kept}, flux);",
            "    }",
            "    return flux;",
            "}",
            "",
        ]

    def _outflow(self) -> list[str]:
        if self.stencil.clamp:
            terms, term = self._offsets, "flux_along(S, at, n, reception, emission)"
        else:
            stride = self.layout.component_stride
            terms, term = self.layout.components, f"(double)S[at + (long long)n * {stride}]"
        body = [
            "const long long at = cells_at[m];",
            _ROLLED,
            f"for (int n = 0; n < {terms}; ++n)",
            f"    left = fma(weights[n * cells + m], {term}, left);",
        ]
        loop = each("m", "cells", LARGEST_BLOCK, body)
        arguments = [_SOURCE, *_CELLS, "const double* __restrict__ weights", *_FLUX, *_REPORT]
        return kernel("outflow", arguments, summing(["left"], LARGEST_BLOCK, loop))

    def _sent(self) -> list[str]:
        dimension = len(self.layout.shape)
        body = [
            *position(self.layout),
            _ROLLED,
            f"for (int d = 0; d < {self._offsets}; ++d)",
            "    sent += flux_along(S, at, d, reception, emission);",
        ]
        loop = each("q", "cells", LARGEST_BLOCK, body)
        arguments = [_SOURCE, *box_arguments(dimension), *_FLUX, *_REPORT]
        summed = summing(["sent"], LARGEST_BLOCK, loop)
        return kernel("sent", arguments, [box_size(dimension), *summed])

    def _reflect(self) -> list[str]:
        """As the reports of steps: components, squares; and the flux that came back."""
        count = len(self.sums)
        names = [f"sum_{i}" for i in range(count + 2)]
        store = [
            "const double old = (double)T[place];",
            # What the field's precision really adds, so that the books agree with it.
            "T[place] = (real)(old + share);",
            "X[place] = (real)((double)X[place] + share);",
            "const double now = (double)T[place];",
            *(f"if (k == {c}) sum_{i} += now - old;" for i, c in enumerate(self.sums)),
            f"sum_{count} += now * now - old * old;",
            f"if (k == 0) sum_{count + 1} += now - old;",
        ]
        block = block_for(len(names))
        loop = each("m", "cells", block, self._returned(store))
        fields = [_SOURCE, "real* __restrict__ T", "real* __restrict__ X"]
        arguments = [*fields, *self._lobes(), *_REPORT]
        return kernel("reflect", arguments, summing(names, block, loop))

    def _add(self) -> list[str]:
        store = ["T[place] = (real)((double)T[place] + factor * share);"]
        loop = each("m", "cells", LARGEST_BLOCK, self._returned(store))
        arguments = [_SOURCE, "real* __restrict__ T", *self._lobes(), "double factor"]
        return kernel("add", arguments, threads(LARGEST_BLOCK, loop))

    def _lobes(self) -> list[str]:
        return [*_CELLS, "const double* __restrict__ lobes", "long long lit", *_FLUX]

    def _returned(self, store: list[str]) -> list[str]:
        """What comes back in a cell: for each of the first `lit` components, its share."""
        stride = self.layout.component_stride
        return [
            "const long long at = cells_at[m];",
            f"double flux[{self._offsets}];",
            _ROLLED,
            f"for (int d = 0; d < {self._offsets}; ++d)",
            "    flux[d] = flux_along(S, at, d, reception, emission);",
            "for (int k = 0; k < lit; ++k) {",
            "    double share = 0.0;",
            f"    for (int d = 0; d < {self._offsets}; ++d)",
            f"        share = fma(lobes[(k * {self._offsets} + d) * cells + m], flux[d], share);",
            f"    const long long place = at + (long long)k * {stride};",
            *indented(store),
            "}",
        ]
