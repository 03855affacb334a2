"""Light that lives on a device while it is stepped."""

from __future__ import annotations

from typing import Any

from flatland.cuda.device import CudaDevice, DeviceArray
from flatland.cuda.sweep import CudaSweep
from flatland.kernels import Layout
from flatland.kernels.any_sweep import AnySweep
from flatland.kernels.box import nothing
from flatland.kernels.reports import Buffer, StepSums
from flatland.light_state import LightState


class CudaState(LightState):
    """A `LightState` whose buffers go to the device with the first step.

    From then on whoever looks at one gets a copy that he cannot write in, fetched anew when light
    has moved since. `lend` and `start` bring the buffers back for good, until the next step.

    What it does otherwise: the box of lit cells grows, and shrinks only when no light is left;
    with `drop`, light comes back to the host to be looked at every few steps.
    """

    def __init__(
        self, layout: Layout, scale: float, skip: bool, drop: float, device: CudaDevice
    ) -> None:
        self._device = device
        self._here: dict[str, Buffer] = {}
        self._there: dict[str, DeviceArray] = {}
        #: Whether the device has the light; and which buffers here are copies of it as it is now.
        self._away = False
        self._copied: set[str] = set()
        super().__init__(layout, scale, skip, drop)

    def _get(self, name: str) -> Buffer:
        buffer = self._here[name]
        if not self._away:
            return buffer
        if name not in self._copied:
            self._there[name].get(out=buffer)
            self._copied.add(name)
        shown = buffer.view()
        shown.flags.writeable = False
        return shown

    def _set(self, name: str, buffer: Buffer) -> None:
        assert not self._away
        self._here[name] = buffer

    source: Any = property(lambda self: self._get("source"), lambda self, b: self._set("source", b))
    target: Any = property(lambda self: self._get("target"), lambda self, b: self._set("target", b))
    total: Any = property(lambda self: self._get("total"), lambda self, b: self._set("total", b))

    def reset(self) -> None:
        self._away = False
        super().reset()

    def lend(self) -> None:
        self._come_back()
        super().lend()

    def trim(self) -> float:
        if not self._away or self._limit > 0:
            self._come_back()
            return super().trim()
        if self.skip and self.norm == 0:
            self._there["source"].fill(0)
            self._copied.discard("source")
            self.lit = nothing(self.layout.shape)
        return 0.0

    def _move(self, count: int, sweep: AnySweep) -> StepSums:
        assert isinstance(sweep, CudaSweep)
        self._go_away()
        there = self._there
        sums = sweep.run(there["target"], there["source"], there["total"], count, self.lit)
        if count % 2:
            there["source"], there["target"] = there["target"], there["source"]
        self._copied = set()
        return sums

    def _go_away(self) -> None:
        if self._away:
            return
        for name, buffer in self._here.items():
            if name not in self._there:
                self._there[name] = self._device.zeros(buffer.size, buffer.dtype)
            self._there[name].set(buffer)
        self._away, self._copied = True, set(self._here)

    def _come_back(self) -> None:
        for name in self._here:
            _ = self._get(name)
        self._away = False
