"""A scene as plain arrays in cell units, for the kernels of the analytic reference."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatland.errors import bad_input
from flatland.grid import Grid
from flatland.harmonics import CircularHarmonics
from flatland.scene import Scene
from flatland.sources import ParallelSource, PointSource, Segment, SegmentSource
from propagators.analytic.overlaps import uncovered

Array = NDArray[np.float64]

#: Cells. Coordinates nearer to a grid line are put onto it: 3 * 0.1 and 0.3 are the same line.
SNAP = 1e-9


@dataclass(frozen=True, eq=False)
class Geometry:
    """What sends and what stops light; lengths in cells, fluxes in watts.

    shape: cells along x and y. emitters: (E, 4) start and stop, each lights its left.
    radiance: (E, C) flux per angle and length, C = max(1, colours). emitter_sources: (E,) place of
    each in scene.sources("lamp"). positions: (P, 2) of point sources, with series (P, K) of
    circular harmonics, lobes (P, 3) flux and direction of a Lambertian lobe, and spectra (P, C).
    directions: (D, 2) of parallel light, with irradiances (D, C) on a perpendicular surface.
    walls: (S, 4) everything opaque, cut at the grid's border. surfaces: (S,) what each wall is:
    the place of an emitter, or E plus the place of a segment in scene.segments().
    albedo: (E plus number of segments, C) of each surface; emitters are black. gates: (S,), which
    walls are emitters on the border with no segment behind: parallel light comes in through them,
    so that a sun and a sky can shine together.
    """

    grid: Grid
    emitters: Array
    radiance: Array
    emitter_sources: NDArray[np.int64]
    positions: Array
    series: Array
    lobes: Array
    spectra: Array
    directions: Array
    irradiances: Array
    walls: Array
    surfaces: NDArray[np.int64]
    albedo: Array
    gates: NDArray[np.bool_]

    @property
    def reflects(self) -> bool:
        """Whether any wall in the grid sends light back."""
        return bool(np.any(self.albedo[self.surfaces] > 0))

    @property
    def border(self) -> Array:
        """The grid's outline (4, 4), counter-clockwise, so that its inside is on the left."""
        nx, ny = self.grid.shape
        corners = np.array([[0, 0], [nx, 0], [nx, ny], [0, ny]], float)
        return np.hstack([corners, np.roll(corners, -1, axis=0)])

    def in_cells(self, point: Array) -> tuple[float, float]:
        """A world point (2,) in cells, put onto a grid line that it nearly lies on."""
        x, y = _snapped(self.grid.to_cells(point))
        return float(x), float(y)

    def point_intensity(self, directions: Array) -> Array:
        """Intensity (K, P, C) [W/rad] of the point sources at unit directions (K, 2)."""
        basis = CircularHarmonics((self.series.shape[1] + 1) // 2)
        lobes = np.maximum(0.0, directions @ self.lobes[:, 1:].T) * self.lobes[:, 0] / 2
        unit = basis.evaluate(directions) @ self.series.T + lobes
        return unit[:, :, None] * self.spectra

    def cell_outlines(self) -> Array:
        """The four faces (cells, 4, 4) of every cell, counter-clockwise; last axis runs fastest."""
        corners = np.moveaxis(np.indices(self.grid.shape), 0, -1).reshape(-1, 1, 2)
        outline = corners + np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
        return np.concatenate([outline, np.roll(outline, -1, axis=1)], axis=-1).astype(float)


def read_geometry(scene: Scene) -> Geometry:
    """The arrays of a scene, without its medium.

    Raises InputError for an emitter without length.
    """
    grid, colours = scene.grid, max(1, scene.colours)
    sources = scene.sources("lamp")
    places = [k for k, source in enumerate(sources) if isinstance(source, SegmentSource)]
    lights = [source for source in sources if isinstance(source, SegmentSource)]
    points = [source for source in sources if isinstance(source, PointSource)]
    beams = [source for source in sources if isinstance(source, ParallelSource)]
    segments = scene.segments()
    emitters = _in_cells(grid, [(light.start, light.stop) for light in lights])
    lengths = np.hypot(*(emitters[:, 2:] - emitters[:, :2]).T)
    if np.any(lengths == 0):
        broken = lights[int(np.argmin(lengths))]
        raise bad_input("stop", broken.stop, "must differ from start: a light needs a length")
    spectra = np.array([light.spectrum for light in lights]).reshape(-1, colours)
    occluders = _in_cells(grid, [(wall.start, wall.stop) for wall in segments])
    walls, surfaces = _inside(grid, np.concatenate([emitters, occluders]))
    return Geometry(
        grid,
        emitters,
        spectra / (2 * lengths[:, None]),
        np.array(places, np.int64),
        _snapped(grid.to_cells(np.array([p.position for p in points]).reshape(-1, 2))),
        _stacked_series(points),
        np.array([_lobe(point) for point in points]).reshape(-1, 3),
        np.array([point.spectrum for point in points]).reshape(-1, colours),
        np.array([beam.direction for beam in beams], float).reshape(-1, 2),
        grid.spacing * np.array([beam.spectrum for beam in beams], float).reshape(-1, colours),
        walls,
        surfaces,
        _albedo(len(emitters), segments, colours),
        _gates(grid, walls, surfaces < len(emitters)),
    )


def _albedo(emitter_count: int, segments: list[Segment], colours: int) -> Array:
    albedo = np.zeros((emitter_count + len(segments), colours))
    for row, segment in zip(albedo[emitter_count:], segments):
        row[:] = segment.albedo
    return albedo


def _gates(grid: Grid, walls: Array, lights: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which of the walls (S, 4) are lights (S,) along the border that no other wall lies on."""
    ends = walls.reshape(-1, 2, 2)
    on_line = np.all((ends == 0) | (ends == grid.shape), axis=1)
    free = [
        np.array_equal(uncovered(wall, walls[~lights]), wall[None]) if light else False
        for wall, light in zip(walls, lights)
    ]
    same_line = np.any(on_line & (ends[:, 0] == ends[:, 1]), axis=1)
    return np.array(free, bool) & same_line


def _snapped(cells: Array) -> Array:
    nearest = np.rint(cells)
    return np.where(np.abs(cells - nearest) < SNAP, nearest, cells)


def _in_cells(grid: Grid, ends: list[tuple[Array, Array]]) -> Array:
    """Segments (K, 4) in cells from pairs of world points."""
    points = np.array(ends, float).reshape(-1, 2, 2)
    return _snapped(grid.to_cells(points)).reshape(-1, 4)


def _inside(grid: Grid, segments: Array) -> tuple[Array, NDArray[np.int64]]:
    """The parts of segments (K, 4) in the grid, and which segment each part is of."""
    start, stop = segments[:, :2].copy(), segments[:, 2:].copy()
    kept = np.ones(len(segments), bool)
    for axis, size in enumerate(grid.shape):
        for sign, offset in ((1.0, 0.0), (-1.0, float(size))):
            # Distance to the border line, positive inside.
            a, b = sign * start[:, axis] + offset, sign * stop[:, axis] + offset
            kept &= np.maximum(a, b) >= 0
            cut = (a / np.where(a == b, 1.0, a - b))[:, None]
            crossing = start + cut * (stop - start)
            crossing[:, axis] = -sign * offset
            start = np.where((a < 0)[:, None], crossing, start)
            stop = np.where((b < 0)[:, None], crossing, stop)
    parts = _snapped(np.hstack([start, stop]))
    kept &= np.any(parts[:, :2] != parts[:, 2:], axis=1)
    return parts[kept], np.flatnonzero(kept)


def _stacked_series(points: list[PointSource]) -> Array:
    """Coefficients (P, K) of all points, padded with zeros to the longest."""
    size = max((len(point.coefficients) for point in points), default=1)
    series = np.zeros((len(points), size))
    for row, point in zip(series, points):
        row[: len(point.coefficients)] = point.coefficients
    return series


def _lobe(point: PointSource) -> tuple[float, float, float]:
    if point.lobe_direction is None:
        return 0.0, 1.0, 0.0
    return point.lobe_flux, float(point.lobe_direction[0]), float(point.lobe_direction[1])
