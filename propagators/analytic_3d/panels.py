"""Light of area lights through flat panels: closed form in angle, two Gauss rules in space."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inner, share_work, shared
from propagators.analytic_3d.cuts import ROOM, height, keep_inside
from propagators.analytic_3d.flow import FlowTables, add_polygon, flow_tables
from propagators.analytic_3d.maps import cosine_maps
from propagators.analytic_3d.plates import TOUCH, Plates, part_above
from propagators.analytic_3d.shadows import Work, collect_blockers, make_work, see

Vector = NDArray[np.float64]
Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]


class Panels(NamedTuple):
    """Convex quadrilaterals that light passes along their normal; a triangle repeats a corner.

    corners: (K, 4, 3), counter-clockwise round the normals (K, 3). groups: (K,) what each adds to.
    """

    corners: Vector
    normals: Vector
    groups: Indices

    def chosen(self, which: Flags | Indices) -> Panels:
        return Panels(self.corners[which], self.normals[which], self.groups[which])

    @property
    def widths(self) -> Vector:
        """Longest edge of each (K,)."""
        edges = np.roll(self.corners, -1, axis=1) - self.corners
        return np.asarray(np.linalg.norm(edges, axis=2).max(axis=1))

    def halved(self) -> Panels:
        """Each panel in four, in order."""
        a, b, c, d = np.moveaxis(self.corners, 1, 0)
        ab, bc, cd, da = (a + b) / 2, (b + c) / 2, (c + d) / 2, (d + a) / 2
        middle = (a + b + c + d) / 4
        quarters = [
            (a, ab, middle, da),
            (ab, b, bc, middle),
            (middle, bc, c, cd),
            (da, middle, cd, d),
        ]
        corners = np.stack([np.stack(each, axis=1) for each in quarters], axis=1)
        normals, groups = np.repeat(self.normals, 4, axis=0), np.repeat(self.groups, 4)
        return Panels(corners.reshape(-1, 4, 3), normals, groups)


def quads_of(polygon: Vector) -> list[Vector]:
    """A convex polygon (V, d) as quadrilaterals (4, d); a triangle repeats its last corner."""
    places = [(0, k, k + 1, min(k + 2, len(polygon) - 1)) for k in range(1, len(polygon) - 1, 2)]
    return [polygon[list(place)] for place in places]


def split_panels(panels: Panels, planes: Vector) -> tuple[Panels, Indices]:
    """Each panel in parts on one side of its plane (K, 4), and which panel each is a part of."""
    corners, origins = [], []
    for k, (panel, plane) in enumerate(zip(panels.corners, planes)):
        heights = panel @ plane[:3] - plane[3]
        for part in (part_above(panel, heights), part_above(panel, -heights)):
            quads = quads_of(part)
            corners += quads
            origins += len(quads) * [k]
    places = np.array(origins, np.int64)
    cut = np.array(corners).reshape(-1, 4, 3)
    return Panels(cut, panels.normals[places], panels.groups[places]), places


class PanelLight(NamedTuple):
    """values: (K, C, size) coefficients. errors: (K,) L2 difference of the two rules.

    shaded: (K,), whether a wall may stand before the panel. crossed: (K,) a light whose plane
    crosses it, or -1: beyond that plane the panel is dark.
    """

    values: Vector
    errors: Vector
    shaded: Flags
    crossed: Indices


def _rule() -> Vector:
    """Rows (u, v, fine weight, fine - coarse weight) of 3 x 3 and 2 x 2 Gauss points on [0, 1]²."""
    rows = []
    for count, fine in ((3, 1.0), (2, 0.0)):
        nodes, weights = np.polynomial.legendre.leggauss(count)
        nodes, weights = (nodes + 1) / 2, weights / 2
        for u, a in zip(nodes, weights):
            rows += [
                (u, v, fine * a * b, a * b * (1 if fine else -1)) for v, b in zip(nodes, weights)
            ]
    return np.array(rows)


_RULE = _rule()
#: Cells. A light whose plane comes this close to a corner does not cross a panel.
CLOSE = 1e-9


def panel_light(
    panels: Panels, lights: Plates, radiance: Vector, walls: Plates, bands: int
) -> PanelLight:
    """∫dA ∫_{n·ω>0} L (n·ω) y dω over panels, light of `lights` with radiance (L, C) past walls.

    The emitter is cut by the panel's plane, walls take their shadows out of it, and what is left
    is integrated in closed form at the points of a 3 x 3 Gauss rule, whose error a 2 x 2 rule
    overestimates where light is smooth.
    """
    count, colours = len(panels.corners), radiance.shape[1]
    values, errors = np.zeros((count, colours, bands**2)), np.zeros(count)
    shaded, crossed = np.zeros(count, bool), np.full(count, -1)
    tables, maps = flow_tables(bands), cosine_maps(bands)
    given = panels.corners, panels.normals, lights, radiance, walls, tables, maps, _RULE
    share_work(_collect, count, *given, values, errors, shaded, crossed)
    return PanelLight(values, errors, shaded, crossed)


@shared
def _collect(
    party: int,
    parties: int,
    corners: Vector,
    normals: Vector,
    lights: Plates,
    radiance: Vector,
    walls: Plates,
    tables: FlowTables,
    maps: Vector,
    rule: Vector,
    values: Vector,
    errors: Vector,
    shaded: Flags,
    crossed: Indices,
) -> None:
    work = make_work(walls.planes.shape[0])
    sums = np.empty((2, radiance.shape[1], maps.shape[2]))
    for k in range(party, corners.shape[0], parties):
        sums.fill(0.0)
        lit, shaded[k], crossed[k] = _gather(
            corners[k], normals[k], lights, radiance, walls, tables, rule, work, sums
        )
        if lit:
            errors[k] = _apply(normals[k], maps, sums, values[k])


@inner
def _gather(
    corners: Vector,
    normal: Vector,
    lights: Plates,
    radiance: Vector,
    walls: Plates,
    tables: FlowTables,
    rule: Vector,
    work: Work,
    sums: Vector,
) -> tuple[bool, bool, int]:
    """sums (2, C, flow) += flows of all lights by the fine rule, and its difference to the coarse.

    Returns whether any light comes near the panel, whether a wall may, and a light whose plane
    crosses it.
    """
    behind, centres = np.empty(4), np.empty((4, 4))
    for axis in range(3):
        behind[axis] = -normal[axis]
    behind[3] = 0.0
    behind[3] = height(corners[0], behind)
    for i in range(4):
        centres[i, :3] = corners[i]
        centres[i, 3] = 1.0
    lit, shadow, crossed = False, False, -1
    pieces, sizes = np.empty((64, ROOM, 3)), np.empty(64, np.int64)
    flow, harmonics = np.empty(sums.shape[2]), np.empty(tables.diagonal.size**2)
    for e in range(lights.planes.shape[0]):
        plane = lights.planes[e]
        lowest, highest = math.inf, -math.inf
        for i in range(4):
            here = height(corners[i], plane)
            lowest, highest = min(lowest, here), max(highest, here)
        if highest <= TOUCH:
            continue
        own = lights.vertices[lights.first[e] : lights.first[e + 1]]
        count = keep_inside(own, own.shape[0], behind, work.window)
        if count < 3:
            continue
        lit = True
        if lowest < -CLOSE and highest > CLOSE:
            crossed = e
        found = collect_blockers(centres, work.window, count, plane, behind, walls, work)
        shadow |= found > 0
        for q in range(rule.shape[0]):
            weight = _place(corners, rule[q, 0], rule[q, 1], centres[0])
            if height(centres[0], plane) <= TOUCH:
                continue
            pieces, sizes, left, _ = see(centres[0], work.window, count, found, work, pieces, sizes)
            if left == 0:
                continue
            flow.fill(0.0)
            add_arriving(centres[0], pieces, sizes, left, tables, harmonics, flow)
            for colour in range(radiance.shape[1]):
                fine = weight * rule[q, 2] * radiance[e, colour]
                difference = weight * rule[q, 3] * radiance[e, colour]
                for j in range(flow.size):
                    sums[0, colour, j] += fine * flow[j]
                    sums[1, colour, j] += difference * flow[j]
        centres[0, :3] = corners[0]
    return lit, shadow, crossed


@inner
def add_arriving(
    point: Vector,
    pieces: Vector,
    sizes: Indices,
    count: int,
    tables: FlowTables,
    harmonics: Vector,
    flow: Vector,
) -> None:
    """flow += that of the directions in which light of convex pieces arrives at a point.

    The pieces are used up: they become directions.
    """
    for p in range(count):
        for i in range(sizes[p]):
            for axis in range(3):
                pieces[p, i, axis] = point[axis] - pieces[p, i, axis]
        add_polygon(pieces[p], sizes[p], tables, harmonics, flow)


@inner
def _place(corners: Vector, u: float, v: float, point: Vector) -> float:
    """The point at (u, v) of a quadrilateral, to `point`; the area that du dv spans there."""
    size = 0.0
    along, across = np.empty(3), np.empty(3)
    for axis in range(3):
        a, b, c, d = corners[0, axis], corners[1, axis], corners[2, axis], corners[3, axis]
        along[axis] = (1.0 - v) * (b - a) + v * (c - d)
        across[axis] = (1.0 - u) * (d - a) + u * (c - b)
        point[axis] = (1.0 - v) * ((1.0 - u) * a + u * b) + v * ((1.0 - u) * d + u * c)
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        size += (along[i] * across[j] - along[j] * across[i]) ** 2
    return math.sqrt(size)


@inner
def _apply(normal: Vector, maps: Vector, sums: Vector, values: Vector) -> float:
    """values (C, size) += Σ_i n_i maps_i sums_0; the norm of the same of sums_1."""
    error = 0.0
    for colour in range(values.shape[0]):
        for s in range(values.shape[1]):
            difference = 0.0
            for axis in range(3):
                if normal[axis] != 0.0:
                    for j in range(maps.shape[2]):
                        term = normal[axis] * maps[axis, s, j]
                        values[colour, s] += term * sums[0, colour, j]
                        difference += term * sums[1, colour, j]
            error += difference * difference
    return math.sqrt(error)
