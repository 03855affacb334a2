"""Sweeps that the engine calls: many steps, or one operator application."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from copy import copy
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.arrivals import written_operations
from flatland.kernels.assembly import SweepText
from flatland.kernels.border import border, outflow_text
from flatland.kernels.box import Box, sweep_box, touches_border, whole
from flatland.kernels.cache import last_cache_bytes
from flatland.kernels.clamping import ClampedFluxes, clamped_steps
from flatland.kernels.compiler import compile_text
from flatland.kernels.layout import VECTOR_BYTES, Layout
from flatland.kernels.matrix_sweep import MatrixSweep
from flatland.kernels.mirroring import Mirrors
from flatland.kernels.recipe import Recipe
from flatland.kernels.reflection import Reflection, Reflector
from flatland.kernels.reports import Buffer, StepSums
from flatland.kernels.shares import is_written_twice, packed_shares
from flatland.kernels.stepping import stepping_text
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
#: Multiply-adds, of light that is not there, in the time that it takes to compile other steps.
_COMPILING = 200_000_000
#: Operations of a step over the whole grid from which steps for a box are compiled before the
#: first one.
_LARGE_STEP = 10_000_000
#: Whole planes are taken for a box that has all but one part in so many of their cells.
_WORTH_A_BOX = 3


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
        self._rows, self._whole = sweep_box(layout, whole(layout.shape))
        self.border_cells, self.border_weights = border(stencil, layout, transmittance)
        self._mirrors = Mirrors(layout, stencil.basis, sums) if any(layout.mirrors) else None
        #: What a solver keeps between right-hand sides; tame: that nothing grows among the walls.
        self.tame = False
        self.prepared: set[str] = set()
        self.known: tuple[Buffer, Buffer] | None = None
        self.double: tuple[bytes | None, Sweep] | None = None
        #: What was compiled, kept as long as it may be called.
        self._code: list[object] = []
        self._wasted = 0
        if self.by_matrices:
            self._matrices = MatrixSweep(stencil, layout, self.transmittance)
            return
        self._steps = self._compiled(self.recipe)

    def prepare(self, lit: Box) -> None:
        """Compile steps for a box ahead, where it is a part of a large grid."""
        work = math.prod(self.layout.shape) * self.operations
        if not self.by_matrices and work > _LARGE_STEP and lit != whole(self.layout.shape):
            _ = self._steps_in_box

    @cached_property
    def _steps_in_box(self) -> Callable[..., None]:
        return self._compiled(replace(self.recipe, boxed=True, large=False))

    @cached_property
    def _steps_anywhere(self) -> Callable[..., None]:
        """For buffers that do not begin on a vector."""
        return self._compiled(replace(self.recipe, large=False))

    def _compiled(self, recipe: Recipe) -> Callable[..., None]:
        text = SweepText(self.stencil, self.layout, recipe).text()
        text += outflow_text(self.layout, self.border_weights)
        text += stepping_text(self._width, self._mirrors is not None)
        code = compile_text(text)
        self._code.append(code)
        return code.function("steps")

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
        steps, rows, box = self._rows_of(lit, count)
        border_cells = len(self.border_cells) if touches_border(lit, self.layout.shape) else 0
        worth = _WORTH_SHARING_CALL if count == 1 else _WORTH_SHARING_BATCH
        parties = self._parties(worth, len(rows), len(rows) * int(box[4] - box[3]))
        sums = np.zeros((parties, count, self._width))
        counter = np.zeros(1, np.int64)
        fields = [address(buffer) for buffer in (source, target, total, self.transmittance)]
        if steps is self._steps and self.recipe.large and any(at % VECTOR_BYTES for at in fields):
            steps = self._steps_anywhere
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

    def _rows_of(
        self, lit: Box, count: int
    ) -> tuple[Callable[..., None], range, NDArray[np.int64]]:
        """Compiled steps for a box, the rows that they count, and their place.

        Whole planes take the steps that know how long a row is. Those for any box are compiled
        once the work that they would have saved is as much as compiling them.
        """
        in_box, box = sweep_box(self.layout, lit)
        per_plane = self._rows // self.layout.shape[0]
        planes = range(lit[0][0] * per_plane, lit[0][1] * per_plane)
        spared = len(planes) * self.layout.width - in_box * int(box[4] - box[3])
        self._wasted += count * max(0, spared) * self.operations
        paid = self._wasted > _COMPILING or "_steps_in_box" in self.__dict__
        if spared * _WORTH_A_BOX > len(planes) * self.layout.width and paid:
            return self._steps_in_box, range(in_box), box
        return self._steps, planes, self._whole

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
        call, tau, box = self._combine, self._tau_address, self._whole.ctypes.data
        numbers = (ctypes.c_double * 3)(*factors)

        def part(party: int, running: int) -> None:
            call(source, target, rest, tau, *rows_of(party, running, self._rows), box, numbers)

        parties = self._parties(_WORTH_SHARING_CALL, self._rows, self._rows * self.layout.width)
        run_shared(part, parties)

    @cached_property
    def _combine(self) -> Callable[..., None]:
        text = SweepText(self.stencil, self.layout, replace(self.recipe, kind="combine")).text()
        code = compile_text(text)
        self._code.append(code)
        return code.function("sweep")

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
