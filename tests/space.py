"""Facets, directions and symmetries in 3D that several tests share."""

import itertools
from dataclasses import dataclass

import numpy as np
import trimesh
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from flatland.scene import Scene
from flatland.sources import Facet

#: All 26 neighbours, and the 6 along the axes.
NEIGHBOURS = np.array([step for step in itertools.product((-1, 0, 1), repeat=3) if any(step)])
AXIAL = NEIGHBOURS[np.abs(NEIGHBOURS).sum(axis=1) == 1]
#: The rotations and reflections of a cube, as matrices.
CUBE = [
    np.diag(signs) @ np.eye(3, dtype=int)[list(order)]
    for order in itertools.permutations(range(3))
    for signs in itertools.product((1, -1), repeat=3)
]
_CORNERS = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))
#: Corners of each face, counter-clockwise from outside.
_FACES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


def facets(*polygons, albedo=0.0, closed=False):
    """Facets from arrays (V, 3)."""
    return [Facet(np.array(p, float), np.atleast_1d(albedo), closed) for p in polygons]


def box_faces(centre, size, rotation=None):
    """The six quads of a box."""
    rotation = np.eye(3) if rotation is None else rotation
    corners = (_CORNERS * size) @ np.transpose(rotation) + centre
    return [corners[face] for face in _FACES]


def rotation(generator):
    """A rotation, all alike."""
    matrix, triangle = np.linalg.qr(generator.normal(size=(3, 3)))
    matrix = matrix * np.sign(np.diag(triangle))
    return matrix * np.linalg.det(matrix)


def sphere_faces(centre, radius, subdivisions=2, turn=None):
    """Triangles (F, 3, 3) of a closed mesh inside a sphere."""
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions)
    vertices = np.asarray(mesh.vertices) @ np.transpose(np.eye(3) if turn is None else turn)
    return (radius * vertices + centre)[mesh.faces]


def triangles_of(polygons):
    """Convex polygons as fans of triangles (T, 3, 3)."""
    return np.array(
        [[p[0], p[i], p[i + 1]] for p in map(np.asarray, polygons) for i in range(1, len(p) - 1)]
    )


def moved(values, step):
    """values(x + step) for those x for which x and x + step lie in the grid."""
    return values[tuple(slice(max(0, s), n + min(0, s)) for s, n in zip(step, values.shape))]


def connected(tau, offsets):
    """Which cells light can get between, through links with τ > 0: a number per cell."""
    number = np.arange(np.prod(tau.shape[1:])).reshape(tau.shape[1:])
    sources, targets = [], []
    for open_share, step in zip(tau, offsets):
        leads = moved(open_share, -step) > 0
        sources.append(moved(number, -step)[leads])
        targets.append(moved(number, step)[leads])
    pairs = np.concatenate(sources), np.concatenate(targets)
    links = coo_array((np.ones(len(pairs[0])), pairs), shape=(number.size, number.size))
    return connected_components(links, directed=False)[1]


def winding(points, triangles):
    """How often a closed surface winds round each point (N,), by its solid angles.

    van Oosterom & Strackee 1983. Anything on the surface itself.
    """
    a, b, c = (triangles[None, :, i] - points[:, None] for i in range(3))
    la, lb, lc = (np.linalg.norm(arm, axis=-1) for arm in (a, b, c))
    volume = np.sum(a * np.cross(b, c), axis=-1)
    others = np.sum(a * b, -1) * lc + np.sum(b * c, -1) * la + np.sum(c * a, -1) * lb
    return np.rint(np.arctan2(volume, la * lb * lc + others).sum(axis=1) / (2 * np.pi)).astype(int)


def on_surface(points, triangles):
    """Which points (N,) lie on triangles."""
    each = np.repeat(triangles, len(points), axis=0)
    there = np.tile(points, (len(triangles), 1))
    feet = trimesh.triangles.closest_point(each, there)
    distances = np.linalg.norm(feet - there, axis=1).reshape(len(triangles), -1)
    return distances.min(axis=0) < 1e-6


def centres_of(shape):
    """Centres of all cells (N, 3)."""
    return np.argwhere(np.ones(shape)) + 0.5


@dataclass(frozen=True)
class Walls3d:
    """An occluder of any facets."""

    polygons: tuple
    albedo: object = 0.0
    closed: bool = False

    @property
    def colours(self):
        return np.size(self.albedo) if np.ndim(self.albedo) else 0

    def walls(self, colours=0):
        albedo = np.broadcast_to(self.albedo, max(1, colours)).astype(float)
        return [Facet(np.array(p, float), albedo, self.closed) for p in self.polygons]


def space_scene(*occluders, shape, light):
    """A scene with facets that no kind of occluder describes."""
    scene = Scene.from_dict({"grid": {"shape": shape}, "light": [light]})
    return scene.model_copy(update={"occluders": occluders})
