"""The area of unions of convex polygons, against GEOS."""

import numpy as np
import pytest
import shapely

from flatland.blocking.polygon_union import union_area


def area_of(polygons):
    first = np.cumsum([0, *map(len, polygons)])
    return union_area(np.concatenate([np.empty((0, 2)), *polygons]), first)


def hulls(generator, count, size=0.5):
    """Convex polygons of 3 to 7 corners, either way round."""
    polygons = []
    while len(polygons) < count:
        points = generator.random((1, 2)) + size * generator.normal(size=(7, 2))
        hull = shapely.convex_hull(shapely.MultiPoint(points))
        polygons.append(np.array(hull.exterior.coords)[:: generator.choice([-1, 1])][1:])
    return polygons


def expected(polygons):
    return shapely.union_all([shapely.Polygon(polygon) for polygon in polygons]).area


def test_nothing_covers_nothing():
    assert area_of([]) == 0


@pytest.mark.parametrize("count", [1, 2, 5, 40])
@pytest.mark.parametrize("size", [0.05, 0.5])
@pytest.mark.parametrize("seed", range(3))
def test_random_polygons(count, size, seed):
    polygons = hulls(np.random.default_rng(seed), count, size)
    assert area_of(polygons) == pytest.approx(expected(polygons), rel=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_polygons_on_a_lattice_share_edges_and_corners(seed):
    generator = np.random.default_rng(seed)
    triangles = list(generator.integers(0, 5, (20, 3, 2)).astype(float))
    assert area_of(triangles) == pytest.approx(expected(triangles), rel=1e-12)


@pytest.mark.parametrize("noise", [0.0, 1e-15, 1e-12])
def test_copies_count_once(noise):
    generator = np.random.default_rng(4)
    (polygon,) = hulls(generator, 1)
    copies = [np.roll(polygon, i, axis=0)[:: (-1) ** i] for i in range(4)]
    noisy = [copy + noise * generator.normal(size=copy.shape) for copy in copies]
    assert area_of(noisy) == pytest.approx(area_of([polygon]), abs=20 * noise + 1e-14)


def test_a_cut_polygon_has_the_area_of_its_parts():
    square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
    inner = np.array([0.3, 0.7])
    parts = [np.array([square[i], square[i - 3], inner]) for i in range(4)]
    assert area_of(parts) == pytest.approx(1.0, abs=1e-15)
    assert area_of([*parts, square]) == pytest.approx(1.0, abs=1e-15)
