"""The light of one grid: all of it, or the half that the rest is the mirror image of."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from flatland.devices import PROCESSOR, Device
from flatland.folding import Fold
from flatland.kernels import Layout
from flatland.light_state import LightState
from flatland.mirror_axes import MirrorAxes
from flatland.occlusion import Occlusion
from flatland.patch import Patch
from flatland.stencil import Stencil


class FoldedLight:
    """One `LightState` per spectrum, for the whole grid until `settle` finds that half will do.

    Others see the whole grid: `LightState.cells` unfolds, and sums of steps are those of all cells.
    Whoever writes into buffers must `unfold` first. skip: whether to look for images. drop: see
    `LightState`; light is dropped where it ends, which the half does not know, so that with `drop`
    nothing is folded; nor is it on another device. scatters: see `MirrorAxes`.
    """

    def __init__(
        self,
        layout: Layout,
        stencil: Stencil,
        scales: Sequence[float],
        skip: bool,
        drop: float,
        scatters: bool,
        device: Device,
    ) -> None:
        self.layout, self._scales, self._rules = layout, tuple(scales), (skip, drop)
        self._device = device
        #: What is stepped; no axes: the whole grid.
        self.fold = self._whole = Fold(layout.shape, stencil.basis, ())
        #: By the axes that are folded.
        self._held: dict[tuple[int, ...], list[LightState]] = {}
        self._settled = False
        here = device is PROCESSOR
        self._mirrors = MirrorAxes(stencil, layout, here and skip and not drop, scatters)

    @property
    def states(self) -> list[LightState]:
        """The light of each spectrum, as far as it is stepped."""
        fold = self.fold
        if fold.axes not in self._held:
            self._held[fold.axes] = [self._dark(fold, scale) for scale in self._scales]
        return self._held[fold.axes]

    def _dark(self, fold: Fold, scale: float) -> LightState:
        if not fold.axes:
            return self._device.state(self.layout, scale, *self._rules)
        return LightState(fold.layout(self.layout), scale, *self._rules, fold)

    def reset(self) -> None:
        """No light anywhere."""
        self.fold, self._settled = self._whole, False
        for states in self._held.values():
            for state in states:
                state.reset()

    def rescale(self, scales: Sequence[float]) -> None:
        """Room for light of other spectra; nothing is lit."""
        if len(scales) != len(self._scales):
            self._held = {}
        self._scales = tuple(scales)
        for states in self._held.values():
            for state, scale in zip(states, scales):
                state.scale = scale
        self.reset()

    def block(self, occlusion: Occlusion) -> None:
        """Other walls from now on; the light stays where it is."""
        self.unfold()
        self._settled = False
        self._mirrors.block(occlusion)

    def settle(self, moved: bool) -> None:
        """Before a step: whether half is enough, of this light among these walls.

        moved: whether it has made any step before, here or elsewhere.
        """
        if not self._settled:
            self._hold(self.fold_now(moved))
            self._settled = True

    def unfold(self) -> None:
        """All light in the buffers of the whole grid; it stays there for good."""
        self._hold(self._whole)
        self._settled = True

    def fold_now(self, moved: bool) -> Fold:
        """What has to be stepped of the light that is here."""
        if self._settled:
            return self.fold
        names = ("source", "target", "total") if moved else ("target",)
        return self.fold_of(state.light(name) for name in names for state in self.states)

    def fold_of(self, light: Iterable[Patch]) -> Fold:
        """What has to be stepped of some light."""
        return replace(self._whole, axes=self._mirrors.of(light))

    def _hold(self, fold: Fold) -> None:
        if fold != self.fold:
            before, self.fold = self.states, fold
            for state, other in zip(self.states, before):
                state.take_over(other)
