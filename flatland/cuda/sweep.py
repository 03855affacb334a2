"""Sweeps on a device: many steps, or one operator application."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flatland.cuda.columns import Columns
from flatland.cuda.device import CudaDevice, DeviceArray, Kernel
from flatland.cuda.local_text import LocalText
from flatland.cuda.parts import BLOCKS, LARGEST_BLOCK, block_for, blocks_for
from flatland.cuda.step_text import StepText
from flatland.cuda.tables import (
    border_cells,
    border_weights,
    leaving_shares,
    lobes_table,
    wall_shares,
)
from flatland.cuda.vectors import gathered
from flatland.kernels.box import Box, cell_count, touches_border, whole
from flatland.kernels.layout import Layout
from flatland.kernels.reflection import Reflection
from flatland.kernels.reports import Buffer, StepSums
from flatland.stencil import Stencil

#: Steps whose reports are fetched together.
_BATCH = 16


class CudaSweep:
    """What `flatland.kernels.Sweep` is on the host, with the same arguments.

    `run` and `apply` take fields that are on the device; `steps` and `combine` bring theirs there
    and back.
    """

    reflection: Reflection | None = None
    _returned: _Returned | None = None

    def __init__(
        self,
        device: CudaDevice,
        stencil: Stencil,
        layout: Layout,
        transmittance: NDArray[np.float64] | None = None,
        sums: tuple[int, ...] = (0,),
    ) -> None:
        self.device, self.stencil, self.layout = device, stencil, layout
        self.open_share, self.sums = transmittance, sums
        self._text = StepText(stencil, layout, transmittance is not None, sums)
        self._local = LocalText(stencil, layout, sums)
        #: The same in double precision, for solvers, and the cells that reflect there.
        self.double: tuple[bytes | None, CudaSweep] | None = None

    def prepared(self) -> CudaSweep:
        """This sweep, with all that steps need compiled and on the device."""
        _ = self._step, self._operands, self._fluxes, self._border, self._partial
        return self

    def prepared_to_solve(self) -> CudaSweep:
        """This sweep, with all that `apply` needs compiled and on the device."""
        _ = self._combine, self._operands, self._fluxes
        return self

    def prepare(self, lit: Box) -> None:
        """Nothing: the same program takes any box."""

    # -- programs and tables, made when they are first needed -----------------------------------

    @cached_property
    def _step(self) -> dict[str, Kernel]:
        """Kernels of a step, but for what walls send back; one text compiles sooner than two."""
        names = ["step", "gather", "outflow", *(["sent"] if self.stencil.clamp else [])]
        return self.device.program(self._text.stepping() + self._local.leaving(), names)

    @cached_property
    def _combine(self) -> Kernel:
        return self.device.program(self._text.combining(), ("combine",))["combine"]

    @cached_property
    def _reflecting(self) -> dict[str, Kernel]:
        return self.device.program(self._local.reflecting(), ("reflect", "add"))

    @cached_property
    def _operands(self) -> tuple[Any, ...]:
        """What `step` and `combine` read beside fields: τ, then the numbers of the stencil."""
        found: list[Any] = []
        if self.open_share is not None:
            walls, shares = wall_shares(self.stencil.offsets, self.layout, self.open_share)
            near = np.int64(shares.size // len(self.stencil.offsets))
            found += [self.device.upload(walls), self.device.upload(shares), near]
        if self._text.looped:
            found.append(self.device.upload(self._text.table.astype(self.layout.dtype)))
        return tuple(found)

    @cached_property
    def _fluxes(self) -> tuple[DeviceArray, DeviceArray]:
        return self.device.upload(self._local.reception), self.device.upload(self._local.emission)

    @cached_property
    def _border(self) -> tuple[Any, ...]:
        """Cells that light leaves the grid from, how many they are, and what they send out."""
        shape = self.layout.shape
        cells = border_cells(shape)
        shares = leaving_shares(self.stencil, shape, cells, self.open_share)
        weights = self._local.weights(border_weights(self.stencil, shares), shares)
        places = self.device.upload(self.layout.index(cells))
        return places, np.int64(len(cells)), self.device.upload(weights)

    @cached_property
    def _partial(self) -> tuple[DeviceArray, DeviceArray]:
        """Room for what blocks report of a batch, and for its sums."""
        rows = _BATCH * self._columns.width
        return self.device.zeros(rows * BLOCKS, np.float64), self.device.zeros(rows, np.float64)

    @property
    def _columns(self) -> Columns:
        return Columns(len(self.sums))

    # -- fields on the device -------------------------------------------------------------------

    def run(
        self,
        source: DeviceArray,
        target: DeviceArray,
        total: DeviceArray,
        count: int,
        lit: Box | None = None,
    ) -> StepSums:
        """As `Sweep.steps`, for fields on the device."""
        reports = []
        while count > 0:
            batch = min(count, _BATCH)
            reports.append(self._batch(source, target, total, batch, lit))
            count -= batch
            if batch % 2:
                source, target = target, source
        return StepSums.joined(reports)

    def _batch(
        self,
        source: DeviceArray,
        target: DeviceArray,
        total: DeviceArray,
        count: int,
        lit: Box | None,
    ) -> StepSums:
        partial, sums = self._partial
        partial.fill(0)
        box = whole(self.layout.shape) if lit is None else lit
        for number in range(count):
            self._one(source, target, total, number * self._columns.width, box)
            source, target = target, source
        found = gathered(self._step["gather"], partial, sums, count * self._columns.width)
        return self._columns.read(
            found.reshape(count, -1), self.stencil.clamp, self._returned is not None
        )

    def _one(
        self, source: DeviceArray, target: DeviceArray, total: DeviceArray, row: int, box: Box
    ) -> None:
        """One step, whose reports begin at a row of `partial`."""
        cells, partial = cell_count(box), self._partial[0]
        first = self._columns.first.items()
        report = {name: (np.int64(row + column), partial) for name, column in first}
        place = tuple(np.int64(value) for first, last in box for value in (first, last - first))
        everywhere = (blocks_for(cells, LARGEST_BLOCK),), (LARGEST_BLOCK,)
        border = (blocks_for(int(self._border[1]), LARGEST_BLOCK),), (LARGEST_BLOCK,)
        if touches_border(box, self.layout.shape):
            outflow = self._step["outflow"]
            outflow(*border, (source, *self._border, *self._fluxes, *report["left"]))
        if self.stencil.clamp:
            sent = self._step["sent"]
            sent(*everywhere, (source, *place, *self._fluxes, *report["sent"]))
        block = self._text.block
        step = self._step["step"]
        step(
            (blocks_for(cells, block),),
            (block,),
            (source, target, total, *self._operands, *place, *report["step"]),
        )
        if self._returned is not None:
            arguments = (source, target, total, *self._returned.operands, *self._fluxes)
            block = block_for(len(self.sums) + 2)
            grid = (blocks_for(self._returned.count, block),)
            self._reflecting["reflect"](grid, (block,), (*arguments, *report["returned"]))

    def apply(
        self,
        factors: tuple[float, float, float],
        source: DeviceArray,
        rest: DeviceArray,
        target: DeviceArray,
    ) -> None:
        """As `Sweep.combine`, for fields on the device."""
        shape = self.layout.shape
        place = tuple(np.int64(value) for cells in shape for value in (0, cells))
        grid = (blocks_for(cell_count(whole(shape)), LARGEST_BLOCK),)
        numbers = tuple(np.float64(factor) for factor in factors)
        arguments = (source, rest, target, *self._operands, *place, *numbers)
        self._combine(grid, (LARGEST_BLOCK,), arguments)
        if self._returned is not None:
            grid = (blocks_for(self._returned.count, LARGEST_BLOCK),)
            operands = (*self._returned.operands, *self._fluxes, np.float64(factors[2]))
            self._reflecting["add"](grid, (LARGEST_BLOCK,), (source, target, *operands))

    # -- fields on the host ---------------------------------------------------------------------

    def steps(
        self, source: Buffer, target: Buffer, total: Buffer, count: int, lit: Box | None = None
    ) -> StepSums:
        """As `Sweep.steps`."""
        here = source, target, total
        there = [self.device.upload(buffer) for buffer in here]
        report = self.run(there[0], there[1], there[2], count, lit)
        for array, buffer in zip(there, here):
            array.get(out=buffer)
        return report

    def combine(
        self, own: float, other: float, arrived: float, source: Buffer, rest: Buffer, target: Buffer
    ) -> None:
        """As `Sweep.combine`."""
        here = self.device.upload(source), self.device.upload(rest), self.device.upload(target)
        self.apply((own, other, arrived), *here)
        here[2].get(out=target)

    def reflecting(self, reflection: Reflection | None) -> CudaSweep:
        """This sweep followed by a reflection; shares programs and tables."""
        if reflection is None:
            return self
        _ = self._operands, self._fluxes, self._reflecting  # once, for all twins
        twin = copy(self)
        twin.double, twin.reflection = None, reflection
        twin._returned = _Returned.of(reflection, self.layout, self.device)
        return twin

    def linear(self) -> CudaSweep:
        """The same sweep without clamping."""
        stencil = replace(self.stencil, clamp=False)
        linear = CudaSweep(self.device, stencil, self.layout, self.open_share, self.sums)
        return linear.reflecting(self.reflection)

    def in_double(self, key: bytes | None, reflection: Reflection | None) -> CudaSweep:
        """The same sweep in float64 with another reflection, kept until `key` changes."""
        if self.double is None or self.double[0] != key:
            layout = replace(self.layout, dtype=np.dtype(np.float64))
            twin = CudaSweep(self.device, self.stencil, layout, self.open_share)
            self.double = key, twin.reflecting(reflection)
        return self.double[1]


@dataclass(frozen=True, eq=False)
class _Returned:
    """A reflection on the device: its cells, how many they are, lobes, and components they have."""

    count: int
    operands: tuple[Any, ...]

    @classmethod
    def of(cls, reflection: Reflection, layout: Layout, device: CudaDevice) -> _Returned:
        lobes, lit = lobes_table(reflection.lobes)
        places = device.upload(layout.index(reflection.cells))
        count = len(reflection.cells)
        return cls(count, (places, np.int64(count), device.upload(lobes), np.int64(lit)))
