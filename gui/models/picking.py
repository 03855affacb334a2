"""Which items of a scene lie near a place of the plane."""

from __future__ import annotations

import numpy as np

from gui.models.session import Session
from gui.models.shapes import Outline, Place, Table, distance_to, outline_of, touches
from gui.models.toml_text import tables_of
from gui.models.tools import Point

#: Places at most that are looked at between two others.
_FINEST = 500


def tables_named(session: Session, name: str) -> list[Table]:
    """The tables of all lights, or of all occluders."""
    found: list[Table] = tables_of(session.document.text).get(name, [])
    return found


def item_near(session: Session, point: Point, reach: float) -> Place | None:
    """The nearest item within reach [m]; lines and points before areas."""
    found = []
    for place, outline in _outlines(session):
        distance = distance_to(outline, point)
        if distance <= reach:
            found.append((outline.closed, distance, place))
    return min(found)[2] if found else None


def items_along(session: Session, start: Point, stop: Point, reach: float) -> list[Place]:
    """Items within reach [m] of the way from start to stop, in the order in which they are met."""
    outlines, way = _outlines(session), np.subtract(stop, start)
    count = 1 + int(min(np.hypot(*way) / reach, _FINEST))
    places = [tuple(start + share * way) for share in np.linspace(0, 1, count + 1)]
    met = [place for at in places for place, line in outlines if distance_to(line, at) <= reach]
    return list(dict.fromkeys(met))


def items_within(session: Session, low: Point, high: Point) -> list[Place]:
    """Items whose points all lie in a rectangle."""
    return [
        place
        for place, outline in _outlines(session)
        if touches(outline, np.array(low), np.array(high))
    ]


def _outlines(session: Session) -> list[tuple[Place, Outline]]:
    """Of all items on show, in the plane that is looked at."""
    grid, plane = session.scene.grid, session.plane
    return [
        ((name, index), outline_of(name, table, grid, plane))
        for name in ("light", "occluder")
        if f"{name}s" in session.display.look.layers
        for index, table in enumerate(tables_named(session, name))
    ]
