"""Directions and weights over parts of the sphere, by other means than the library's."""

import itertools

import numpy as np
from scipy.integrate import lebedev_rule

#: Faces of a neighbouring cell, seen from a cell's centre (Kirsch 2010, 2.2).
FRONT_FACE = 0.5 * np.array([(1, 1, 3), (-1, 1, 3), (-1, -1, 3), (1, -1, 3)])
SIDE_FACE = 0.5 * np.array([(1, 1, -1), (1, 3, -1), (1, 3, 1), (1, 1, 1)])
OCTANT = np.eye(3)
#: Five corners around an axis, 80 degrees from it and not regular.
AROUND = np.array([0.0, 1.0, 2.5, 3.4, 5.0])
WIDE = np.stack(
    [np.sin(1.4) * np.cos(AROUND), np.sin(1.4) * np.sin(AROUND), np.full(5, np.cos(1.4))], axis=-1
)
POLYGONS = {"front face": FRONT_FACE, "side face": SIDE_FACE, "octant": OCTANT, "wide": WIDE}


def sphere(degree=47):
    """Directions (K, 3) and weights over the whole sphere."""
    points, weights = lebedev_rule(degree)
    return points.T, weights


def over_triangle(a, b, c, count=40):
    """Over a spherical triangle: Gauss points on the flat one, squeezed into its corner a.

    A flat piece dA with normal n seen from the origin at p subtends |n·p| dA / |p|³.
    """
    a, b, c = (np.asarray(corner, float) for corner in (a, b, c))
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes, weights = (nodes + 1) / 2, weights / 2
    u, v = (grid.ravel() for grid in np.meshgrid(nodes, nodes, indexing="ij"))
    points = a + u[:, None] * (b - a) + (u * v)[:, None] * (c - b)
    area = np.cross(b - a, c - a)  # twice the triangle's, times its normal
    length = np.linalg.norm(points, axis=-1)
    share = np.outer(weights, weights).ravel() * u * np.abs(points @ area) / length**3
    return points / length[:, None], share


def over_polygon(vertices, count=40):
    """Over a convex spherical polygon (V, 3), in triangles around its middle."""
    corners = vertices / np.linalg.norm(vertices, axis=-1, keepdims=True)
    middle = corners.mean(axis=0)
    triangles = [
        over_triangle(middle, a, b, count) for a, b in zip(corners, np.roll(corners, -1, 0))
    ]
    directions, weights = zip(*triangles)
    return np.concatenate(directions), np.concatenate(weights)


def cube_symmetries():
    """The 48 matrices that map the cube to itself."""
    for order in itertools.permutations(range(3)):
        for signs in itertools.product((1, -1), repeat=3):
            yield np.diag(signs) @ np.eye(3, dtype=int)[list(order)]


def representation(basis, turn):
    """What turning an intensity, S(ω) to S(g⁻¹ω), does to its coefficients, (size, size)."""
    directions, weights = sphere()
    return (basis.evaluate(directions).T * weights) @ basis.evaluate(directions @ turn)


def cube_faces():
    """The six faces of a cube, each counter-clockwise seen from outside."""
    square = np.array([(1, 1, 1), (-1, 1, 1), (-1, -1, 1), (1, -1, 1)])
    turns = [turn for turn in cube_symmetries() if np.linalg.det(turn) > 0]
    faces = {tuple(turn[:, 2]): square @ turn.T for turn in turns}
    return np.array(list(faces.values()))
