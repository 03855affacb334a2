"""The light that arrives in one vector of cells, as assembly."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property

import numpy as np

from flatland.kernels.orbits import Orbit, operations, orbits_of, significant
from flatland.kernels.writer import Writer
from flatland.stencil import Stencil


class Arrivals:
    """Writes A S in a vector of cells: by orbits of neighbours, or by faces where it is clamped."""

    def __init__(self, writer: Writer, stencil: Stencil) -> None:
        self.writer, self.stencil, layout = writer, stencil, writer.layout
        # Gathering: what arrives at x along d was at x - d.
        self.shifts = [-layout.shift(offset) for offset in stencil.offsets]
        if stencil.clamp:
            assert stencil.reception is not None
            assert stencil.emission is not None
            self._reception = significant(stencil.reception)
            self._emission = significant(stencil.emission)

    @cached_property
    def _orbits(self) -> list[Orbit]:
        return orbits_of(self.stencil)

    def at(
        self, base: str, column: int, outputs: Sequence[int], shares: str | None
    ) -> dict[int, str]:
        """What each of some components gets, by its number; no entry where that is nothing.

        The vector starts at `base` + `column`. shares: position of its τ, None where no wall is.
        """
        light = _Light(self, base, column, shares)
        return self._clamped(light, outputs) if self.stencil.clamp else self._linear(light, outputs)

    def _linear(self, light: _Light, outputs: Sequence[int]) -> dict[int, str]:
        arrived: dict[int, str] = {}
        for orbit in self._orbits:
            sums = _OrbitSums(light, orbit)
            for k in range(orbit.transfer.shape[1]):
                for output in outputs:
                    number = orbit.transfer[output, k]
                    if number != 0.0:
                        summed = sums.of(k, int(orbit.flips[output, k]))
                        weight = self.writer.constant(number)
                        arrived[output] = self.writer.fused(summed, weight, arrived.get(output))
        return arrived

    def _clamped(self, light: _Light, outputs: Sequence[int]) -> dict[int, str]:
        """Face fluxes first, negative ones dropped, then the lobes."""
        arrived: dict[int, str] = {}
        for d in range(len(self.shifts)):
            for face in range(self._reception.shape[1]):
                flux = self._flux(light, d, face)
                if flux is None:
                    continue
                kept = self.writer.call("maxnum", flux, "zeroinitializer")
                for output in outputs:
                    if self._emission[d, output, face] != 0.0:
                        weight = self.writer.constant(self._emission[d, output, face])
                        arrived[output] = self.writer.fused(kept, weight, arrived.get(output))
        return arrived

    def _flux(self, light: _Light, d: int, face: int) -> str | None:
        flux: str | None = None
        for k in np.flatnonzero(self._reception[d, face]):
            weight = self.writer.constant(self._reception[d, face, k])
            flux = self.writer.fused(light.along(d, int(k)), weight, flux)
        return flux


class _Light:
    """The light of a vector's neighbours, each loaded once."""

    def __init__(self, arrivals: Arrivals, base: str, column: int, shares: str | None) -> None:
        self.writer, self._shifts, self._shares = arrivals.writer, arrivals.shifts, shares
        self._base, self._column = base, column
        self._loaded: dict[tuple[int, int], str] = {}
        self._passing: dict[int, str] = {}

    def along(self, d: int, k: int) -> str:
        """Component k of what arrives along offset d, after walls."""
        if (d, k) not in self._loaded:
            layout = self.writer.layout
            place = self._column + self._shifts[d] + k * layout.component_stride
            light = self.writer.load("%S", self._base, place)
            if self._shares is not None:
                light = self.writer.binary("fmul", light, self._share(d))
            self._loaded[d, k] = light
        return self._loaded[d, k]

    def _share(self, d: int) -> str:
        assert self._shares is not None
        if d not in self._passing:
            place = d * self.writer.layout.lanes
            self._passing[d] = self.writer.load("%tau", self._shares, place)
        return self._passing[d]


class _OrbitSums:
    """Sums and differences of an orbit's neighbours, each written once, when it is asked for."""

    def __init__(self, light: _Light, orbit: Orbit) -> None:
        self._light, self._orbit = light, orbit
        self._known: dict[tuple[int, int, int, int], str] = {}

    def of(self, k: int, flip: int) -> str:
        """Σ ± component k of the members, minus where they are turned along an odd number of the
        axes in `flip`."""
        return self._node(k, len(self._orbit.axes), flip, 0)

    def _node(self, k: int, depth: int, prefix: int, rest: int) -> str:
        """The sum over the first `depth` axes, of the member `rest` along the others."""
        if depth == 0:
            return self._light.along(self._orbit.members[rest], k)
        key = (k, depth, prefix, rest)
        if key not in self._known:
            turned = 1 << (len(self._orbit.axes) - depth)
            parts = [self._node(k, depth - 1, prefix >> 1, rest | bit) for bit in (0, turned)]
            operation = "fsub" if prefix & 1 else "fadd"
            self._known[key] = self._light.writer.binary(operation, *parts)
        return self._known[key]


def written_operations(stencil: Stencil) -> int:
    """Additions and multiply-adds of one cell, as they are written out; their time bounds a step's.

    Those of storing and of the books are not among them.
    """
    if not stencil.clamp:
        return operations(orbits_of(stencil))
    factors: Iterable[np.ndarray | None] = (stencil.reception, stencil.emission)
    return sum(int(np.count_nonzero(significant(f))) for f in factors if f is not None)
