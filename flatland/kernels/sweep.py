"""Sweeps that the engine calls: many steps, or one operator application."""

from __future__ import annotations

import ctypes
from copy import copy
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.arrivals import written_operations
from flatland.kernels.border import border
from flatland.kernels.box import Box, touches_border, whole
from flatland.kernels.cache import last_cache_bytes
from flatland.kernels.clamping import ClampedFluxes, clamped_steps
from flatland.kernels.layout import VECTOR_BYTES, Layout
from flatland.kernels.matrix_sweep import MatrixSweep
from flatland.kernels.mirroring import Mirrors
from flatland.kernels.programs import Programs
from flatland.kernels.recipe import Recipe
from flatland.kernels.reflection import Reflection, Reflector
from flatland.kernels.reports import Buffer, StepSums
from flatland.kernels.shares import is_written_twice, packed_shares
from flatland.kernels.threads import address, rows_of, run_shared, thread_count, yield_address
from flatland.stencil import Stencil

#: Operations above which the written-out sweep takes too long to compile (about 1 s), and blocked
#: matrix products take over.
LARGEST_TEXT = 6000
#: Multiply-adds a step below which one thread is used. In a batch sharing pays from 0.3 million on
#: an idle machine; on a busy one threads wait for each other, 10 times longer than they work at
#: that size, so that only steps of 0.1 ms and more are shared.
_WORTH_SHARING_BATCH = 1_000_000
_WORTH_SHARING_CALL = 3_000_000


class Sweep:
    """One stencil on one layout: T = A S with everything that belongs to a step in the same pass.

    transmittance: (K, *shape), τ(x, d) of light that leaves x along offset d; None: nothing blocks.
    sums: components whose sum over cells every step reports.

    On a layout with mirrors, τ is given with the layers of images, and `steps` reports sums over
    the whole field. `combine` knows no mirrors.
    """

    #: What walls send back; see `reflecting`.
    reflection: Reflection | None = None
    _reflector: Reflector | None = None

    def __init__(
        self,
        stencil: Stencil,
        layout: Layout,
        transmittance: NDArray[np.float64] | None = None,
        sums: tuple[int, ...] = (0,),
    ) -> None:
        self.stencil, self.layout = stencil, layout
        large = 3 * layout.size * layout.dtype.itemsize > last_cache_bytes()
        self.recipe = Recipe(blocked=transmittance is not None, large=large, sums=sums)
        self.operations = written_operations(stencil)
        self.open_share = transmittance
        self.by_matrices = self.operations > LARGEST_TEXT
        self.transmittance: Buffer | None = None
        if transmittance is not None and self.by_matrices:
            self.transmittance = self._padded(transmittance)
        elif transmittance is not None:
            everywhere = not is_written_twice(self.operations)
            self.transmittance = packed_shares(stencil.offsets, layout, transmittance, everywhere)
        self._tau_address = address(self.transmittance)
        self.border_cells, self.border_weights = border(stencil, layout, transmittance)
        self._mirrors = Mirrors(layout, stencil.basis, sums) if any(layout.mirrors) else None
        #: What a solver keeps between right-hand sides; tame: that nothing grows among the walls.
        self.tame = False
        self.prepared: set[str] = set()
        self.known: tuple[Buffer, Buffer] | None = None
        self.double: tuple[bytes | None, Sweep] | None = None
        if self.by_matrices:
            self._matrices = MatrixSweep(stencil, layout, self.transmittance)
            return
        self.programs = Programs(stencil, layout, self.recipe, self.border_weights)
        _ = self.programs.steps

    def prepare(self, lit: Box) -> None:
        """Compile ahead what steps in a box need."""
        if not self.by_matrices:
            self.programs.prepare(lit)

    @cached_property
    def clamped(self) -> ClampedFluxes:
        """For the books of a clamped scheme."""
        return ClampedFluxes(self.stencil, self.layout, self.open_share)

    @property
    def _width(self) -> int:
        return len(self.recipe.sums) + 2

    def steps(
        self,
        source: Buffer,
        target: Buffer,
        total: Buffer,
        count: int,
        lit: Box | None = None,
    ) -> StepSums:
        """`count` steps from `source`, in turn into `target` and back, each added to `total`.

        After an even number of steps the newest light is in `source`. lit: the box outside of which
        `source` and `target` are zero and stay so; what lies outside is not touched.
        """
        if self._reflector is not None:
            report = self._reflected_steps(source, target, total, count, lit)
        elif self.stencil.clamp:
            report = clamped_steps(self, source, target, total, count, lit)
        else:
            report = self.plain_steps(source, target, total, count, lit)
        return report if self._mirrors is None else self._mirrors.of_whole(report)

    def reflecting(self, reflection: Reflection | None) -> Sweep:
        """This sweep followed by a reflection; shares the compiled code."""
        if reflection is None:
            return self
        twin = copy(self)
        twin.tame, twin.known, twin.double = False, None, None
        twin.prepared = set()
        twin.reflection = reflection
        twin._reflector = Reflector(reflection, self.stencil, self.layout)
        return twin

    def _reflected_steps(
        self,
        source: Buffer,
        target: Buffer,
        total: Buffer,
        count: int,
        lit: Box | None,
    ) -> StepSums:
        """Steps one by one, each followed by what walls send back."""
        assert self._reflector is not None
        sweep = clamped_steps if self.stencil.clamp else Sweep.plain_steps
        reports = []
        for _ in range(count):
            report = sweep(self, source, target, total, 1, lit)
            change = self._reflector.step(source, target, total)
            components = report.components + change[list(self.recipe.sums)]
            squares = report.squares + change[-2]
            reports.append(
                replace(report, components=components, squares=squares, reflected=change[-1:])
            )
            source, target = target, source
        return StepSums.joined(reports)

    def plain_steps(
        self,
        source: Buffer,
        target: Buffer,
        total: Buffer,
        count: int,
        lit: Box | None = None,
    ) -> StepSums:
        """Steps whose `left` is that of the stencil's transfer matrices."""
        images = (0, 0)
        if self._mirrors is not None:
            images = self._mirrors.addresses
            for buffer in (source, target):  # others may have written there
                self._mirrors.fill(buffer)
        if self.by_matrices:
            return self._matrices.steps(
                source, target, total, count, self.recipe.sums, self.outflow, self._mirrors
            )
        lit = lit or whole(self.layout.shape)
        steps, rows, box = self.programs.for_box(lit, count)
        border_cells = len(self.border_cells) if touches_border(lit, self.layout.shape) else 0
        worth = _WORTH_SHARING_CALL if count == 1 else _WORTH_SHARING_BATCH
        parties = self._parties(worth, len(rows), len(rows) * int(box[4] - box[3]))
        sums = np.zeros((parties, count, self._width))
        counter = np.zeros(1, np.int64)
        fields = [address(buffer) for buffer in (source, target, total, self.transmittance)]
        cut = self.recipe.large and any(at % VECTOR_BYTES for at in fields)
        if cut and steps is self.programs.steps:
            steps = self.programs.steps_anywhere
        border = [address(self.border_cells), address(self.border_weights)]

        def part(party: int, running: int) -> None:
            own = [rows.start + row for row in rows_of(party, running, len(rows))]
            cells = rows_of(party, running, border_cells)
            steps(
                *fields, *own, address(box), sums[party].ctypes.data, count, *border, *cells,
                counter.ctypes.data, running, yield_address(), *images,
            )  # fmt: skip

        run_shared(part, parties)
        joined = sums.sum(axis=0)
        return StepSums(joined[:, :-2], joined[:, -2], joined[:, -1])

    def linear(self) -> Sweep:
        """The same sweep without clamping."""
        stencil = replace(self.stencil, clamp=False)
        tau = self.open_share
        return Sweep(stencil, self.layout, tau, self.recipe.sums).reflecting(self.reflection)

    def combine(
        self, own: float, other: float, arrived: float, source: Buffer, rest: Buffer, target: Buffer
    ) -> None:
        """target = own·source + other·rest + arrived·(A source), for solvers."""
        if self.by_matrices:
            self._matrices.apply(source, target)
            target *= arrived
            target += own * source + other * rest
        else:
            self.combine_at((own, other, arrived), address(source), address(rest), address(target))
        if self._reflector is not None:
            self._reflector.add(source, target, arrived)

    def combine_at(
        self, factors: tuple[float, float, float], source: int, rest: int, target: int
    ) -> None:
        """`combine` on memory addresses, for callers whose buffers stay where they are.

        Looking up one address takes 2 µs, as long as the whole sweep of a coarse grid.
        """
        programs, tau = self.programs, self._tau_address
        box, numbers = programs.whole_box.ctypes.data, (ctypes.c_double * 3)(*factors)
        call, rows = programs.combine, programs.rows

        def part(party: int, running: int) -> None:
            call(source, target, rest, tau, *rows_of(party, running, rows), box, numbers)

        run_shared(part, self._parties(_WORTH_SHARING_CALL, rows, rows * self.layout.width))

    def outflow(self, source: Buffer) -> float:
        """Flux (in units of coefficient 0) that one step from `source` loses over the border."""
        offsets = np.arange(self.layout.components) * self.layout.component_stride
        light = source[self.border_cells[:, None] + offsets]
        return float(np.sum(light * self.border_weights, dtype=float))

    def _parties(self, worth: int, rows: int, cells: int) -> int:
        return min(thread_count(), rows) if self.operations * cells > worth else 1

    def _padded(self, transmittance: NDArray[np.float64]) -> Buffer:
        """τ in the layout of the fields, its border 1 (only zeros come from there)."""
        layout = replace(self.layout, components=len(self.stencil.offsets))
        buffer = layout.allocate()
        layout.view(buffer, images=True)[...] = transmittance
        return buffer
