"""Segments cut at grid lines: nothing is lost, and every part lies where it says."""

import numpy as np
import pytest

from propagators.transport.cell_items import items_in_cells

SHAPE = (7, 5)


def random_segments(seed, step):
    rng = np.random.default_rng(seed)
    ends = rng.uniform(0, 1, (40, 4)) * [7, 5, 7, 5]
    ends = np.round(ends / step) * step if step else ends
    return ends[np.any(ends[:, :2] != ends[:, 2:], axis=1)]


def lengths(ends):
    return np.hypot(*(ends[:, 2:] - ends[:, :2]).T)


@pytest.mark.parametrize("step", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("seed", range(5))
def test_parts_add_up_to_the_segments(seed, step):
    segments = random_segments(seed, step)
    total = np.zeros(len(segments))
    for items in items_in_cells(segments, SHAPE):
        np.add.at(total, items.segments, lengths(items.ends))
    np.testing.assert_allclose(total, lengths(segments), rtol=1e-12)


@pytest.mark.parametrize("step", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("seed", range(5))
def test_parts_lie_in_their_cell_or_on_their_face(seed, step):
    items = items_in_cells(random_segments(seed, step), SHAPE)
    (nx, ny), rounding = SHAPE, 1e-12
    corners = {
        "cells": [(i, j) for i in range(nx) for j in range(ny)],
        "x_faces": [(i, j) for i in range(nx + 1) for j in range(ny)],
        "y_faces": [(i, j) for i in range(nx) for j in range(ny + 1)],
    }
    extents = {"cells": (1, 1), "x_faces": (0, 1), "y_faces": (1, 0)}
    for name, places in corners.items():
        found = getattr(items, name)
        assert found.first[-1] == len(found.segments)
        for k, corner in enumerate(places):
            points = found.ends[found.first[k] : found.first[k + 1]].reshape(-1, 2)
            assert np.all(points >= np.array(corner) - rounding)
            assert np.all(points <= np.add(corner, extents[name]) + rounding)


def test_parts_keep_the_direction_and_share_their_ends():
    items = items_in_cells(np.array([[6.3, 4.1, 0.2, 1.7]]), SHAPE).cells
    assert np.all(items.ends[:, 2] < items.ends[:, 0])
    ordered = items.ends[np.argsort(-items.ends[:, 0])]
    np.testing.assert_array_equal(ordered[1:, :2], ordered[:-1, 2:])
    np.testing.assert_array_equal(ordered[0, :2], [6.3, 4.1])
    np.testing.assert_array_equal(ordered[-1, 2:], [0.2, 1.7])


def test_what_lies_on_the_border_is_on_its_faces():
    items = items_in_cells(np.array([[7.0, 1.0, 7.0, 3.5], [0.0, 0.0, 2.0, 0.0]]), SHAPE)
    assert len(items.cells.segments) == 0
    assert np.flatnonzero(np.diff(items.x_faces.first)).tolist() == [36, 37, 38]
    assert np.flatnonzero(np.diff(items.y_faces.first)).tolist() == [0, 6]
