"""Which part of the plane is on show: shared by all views, so that they move together."""

from __future__ import annotations

from gui.models.events import Event

#: Device pixels per cell: whole numbers, or one over one, so that all cells look alike.
_ZOOMS = (
    *(1 / n for n in (32, 24, 16, 12, 8, 6, 4, 3, 2)),
    *range(1, 16),
    *(16, 18, 20, 22, 24, 28, 32, 36, 40, 48, 56, 64, 80, 96, 112, 128, 160, 192, 224, 256),
    *(320, 384, 448, 512, 640, 768, 1024),
)


class Camera:
    """centre: cell coordinates in the middle of every view. zoom: device pixels per cell.

    fitted: whether the whole grid is to be seen, whatever the size of the views; ends when the
    user moves or zooms.
    """

    def __init__(self) -> None:
        self.centre = (0.0, 0.0)
        self.zoom: float = 16
        self.fitted = True
        self.changed = Event()

    def fit(self, shape: tuple[int, int], width: float, height: float) -> None:
        """The largest zoom at which the whole grid fits into device pixels."""
        room = min(width / (shape[0] + 0.6), height / (shape[1] + 0.6))
        zoom = max((z for z in _ZOOMS if z <= room), default=_ZOOMS[0])
        if room >= 16:
            zoom = int(room)
        self._set((shape[0] / 2, shape[1] / 2), zoom, True)

    def pan(self, right: float, up: float) -> None:
        """Move what is seen by device pixels."""
        moved = self.centre[0] - right / self.zoom, self.centre[1] - up / self.zoom
        self._set(moved, self.zoom, False)

    def zoom_by(self, steps: int, around: tuple[float, float]) -> None:
        """Some zoom steps in (or, negative, out); the cell coordinate `around` stays in place."""
        order = sorted({*_ZOOMS, self.zoom})
        place = order.index(self.zoom) + steps
        zoom = order[min(max(place, 0), len(order) - 1)]
        if zoom == self.zoom:
            return
        ratio = self.zoom / zoom
        centre = tuple(a + (c - a) * ratio for a, c in zip(around, self.centre))
        self._set((centre[0], centre[1]), zoom, False)

    def refit(self) -> None:
        """Show the whole grid again, at the next chance."""
        self.fitted = True
        self.changed.emit()

    def _set(self, centre: tuple[float, float], zoom: float, fitted: bool) -> None:
        if (centre, zoom, fitted) != (self.centre, self.zoom, self.fitted):
            self.centre, self.zoom, self.fitted = centre, zoom, fitted
            self.changed.emit()
