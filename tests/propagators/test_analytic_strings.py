"""Analytic reference: flux between two segments by Hottel's crossed strings (1954)."""

import numpy as np
import pytest
from analytic_scenes import make_scene

from propagators.analytic import Analytic

PLATE = ((2, 1), (4, 1), 4.0)
RECEIVER = ((2, 5), (4, 5))


def received(walls):
    """Share of the plate's flux that the first wall absorbs."""
    scene = make_scene(lights=[PLATE], walls=walls)
    return Analytic().absorbed(scene)[0] / 4


def test_parallel_plates():
    # Two plates of width w at distance d: F = sqrt(1 + (d/w)^2) - d/w.
    assert received([RECEIVER]) == pytest.approx(np.sqrt(1 + 4) - 2, abs=1e-14)


def test_perpendicular_plates_with_a_common_edge():
    # Widths a and b: F = (a + b - sqrt(a^2 + b^2)) / 2a.
    assert received([((4, 1), (4, 6))]) == pytest.approx((2 + 5 - np.sqrt(29)) / 4, abs=1e-14)


def test_slanted_plate():
    share = received([((5, 2), (3, 6))])
    crossed = np.hypot(3, 1) + np.hypot(1, 5)
    uncrossed = np.hypot(1, 1) + np.hypot(1, 5)
    assert share == pytest.approx((crossed - uncrossed) / 4, abs=1e-14)


@pytest.mark.parametrize("tip", [2.0, 2.3, 3.0, 3.3, 3.8])
def test_strings_bend_around_a_wall_from_the_left(tip):
    def string(start, stop):
        middle = (start + stop) / 2
        bent = np.hypot(tip - start, 2) + np.hypot(stop - tip, 2)
        return np.hypot(stop - start, 4) if middle > tip else bent

    expected = (string(2, 4) + string(4, 2) - string(2, 2) - string(4, 4)) / 4
    assert received([RECEIVER, ((0, 3), (tip, 3))]) == pytest.approx(expected, abs=1e-14)


def test_past_a_wall_in_the_middle_light_goes_left_or_right():
    both = received([RECEIVER, ((2.75, 3), (3.25, 3.5))])
    left = received([RECEIVER, ((2.75, 3), (8, 3))])
    right = received([RECEIVER, ((0, 3.5), (3.25, 3.5))])
    assert both == pytest.approx(left + right, abs=1e-14)


def test_a_closed_wall_lets_nothing_through():
    assert received([RECEIVER, ((0, 3), (8, 3))]) == 0


def test_a_light_receives_on_its_rear_too():
    ledger = Analytic().energy(make_scene(lights=[PLATE, ((2, 5), (4, 5), 1.0)], walls=()))
    assert ledger.absorbed == pytest.approx(4 * (np.sqrt(5) - 2), abs=1e-14)
