"""The same scene on a finer grid."""

from __future__ import annotations

from numbers import Integral

from flatland.errors import bad_input
from flatland.scene.model import Scene


def refined(scene: Scene, factor: int) -> Scene:
    """Lights and walls as they are, cells `factor` times as small along every axis.

    Whatever is given in metres stays. A light that counts in cells follows them: a `wall` becomes
    a row of more points; a `cell` stays the point it is, which only odd factors allow.
    Raises InputError for other factors than whole ones, for lights that cannot follow (data files)
    and for grids that would not fit into memory.
    """
    if not isinstance(factor, Integral) or isinstance(factor, bool) or factor < 1:
        raise bad_input("resolution", factor, "must be a whole number, at least 1")
    if factor == 1:
        return scene
    grid = scene.grid
    tables = scene.to_dict()
    shape = [factor * cells for cells in grid.shape]
    tables["grid"] = {**tables["grid"], "shape": shape, "spacing": grid.spacing / factor}
    if scene.lights:
        tables["light"] = [light.refined(int(factor)) for light in scene.lights]
    return Scene.from_dict(tables, f"{scene.title or 'scene'} at resolution {factor}")
