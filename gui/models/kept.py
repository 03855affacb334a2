"""Runs that are kept, to compare the next with."""

from __future__ import annotations

from dataclasses import dataclass

from flatland.field import Field
from flatland.scene import Scene
from gui.models.track import Track


@dataclass(frozen=True, eq=False)
class KeptRun:
    """A run that is kept to compare with: drawn over the cells and in the curves."""

    label: str
    scheme: str
    field: Field
    track: Track
    scene: Scene
    visible: bool = True
