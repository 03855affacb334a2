"""Colours as numbers: packed 0xffRRGGBB, maps, and colours of coloured light."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

Packed = NDArray[np.uint32]
Array = NDArray[np.floating]


@dataclass(frozen=True)
class Palette:
    """Colours of the canvas, "#rrggbb". paper: behind everything; ink: text and occluders."""

    paper: str
    outside: str
    ink: str
    grid: str
    level: str
    negative: str
    light: str
    selected: str
    exact: str
    faint: str

    @property
    def dark(self) -> bool:
        return int(self.paper[1:3], 16) < 128


LIGHT = Palette(
    paper="#ffffff",
    outside="#eceef0",
    ink="#16191d",
    grid="#e3e6ea",
    level="#7a828c",
    negative="#8a2be2",
    light="#e0a800",
    selected="#0a66d6",
    exact="#b0b0b0",
    faint="#6b7480",
)
DARK = Palette(
    paper="#14171b",
    outside="#0c0e11",
    ink="#f0f2f5",
    grid="#262b31",
    level="#8a949f",
    negative="#c08cff",
    light="#ffd24a",
    selected="#5aa9ff",
    exact="#6d747c",
    faint="#98a2ad",
)


def pack(colour: str) -> int:
    """ "#rrggbb" as 0xffRRGGBB."""
    return 0xFF000000 | int(colour[1:], 16)


def mixed(one: str, other: str, share: float) -> str:
    """A colour between two; share 0 is the first."""
    a, b = (np.array([int(c[i : i + 2], 16) for i in (1, 3, 5)]) for c in (one, other))
    return "#" + "".join(f"{round(float(x)):02x}" for x in a + (b - a) * share)


@cache
def heat_map() -> Packed:
    """Matplotlib's cividis, 256 packed colours: readable without colour vision and in grey."""
    from matplotlib import colormaps

    return pack_rgb(colormaps["cividis"](np.arange(256))[:, :3])


def pack_rgb(rgb: Array) -> Packed:
    """Colours (..., 3) from 0 to 1 as (...)."""
    bytes_ = np.rint(np.clip(rgb, 0, 1) * 255).astype(np.uint32)
    packed = 0xFF000000 | bytes_[..., 0] << 16 | bytes_[..., 1] << 8 | bytes_[..., 2]
    return np.asarray(packed, np.uint32)


def light_hues(flux: Array) -> NDArray[np.float64]:
    """The hue of coloured light (3, ...) as (..., 3) from 0 to 1, as bright as a screen shows it.

    Its strength is the size of the lobe. Channels to the power 1/2.2, as screens expect.
    """
    top = np.maximum(np.max(flux, axis=0), 1e-300)
    shares = np.clip(np.moveaxis(flux / top, 0, -1), 0, 1)
    return np.asarray(shares ** (1 / 2.2), np.float64)


def hues_on(hues: NDArray[np.float64], dark: bool) -> Packed:
    """Hues as packed colours; on light paper deeper ones, which stand out against it."""
    if dark:
        return pack_rgb(hues)
    grey = hues.min(axis=-1, keepdims=True)
    deeper = hues - 0.55 * grey
    brightness = deeper @ np.array([0.3, 0.59, 0.11])
    return pack_rgb(deeper * np.minimum(1.0, 0.45 / np.maximum(brightness, 1e-9))[..., None])
