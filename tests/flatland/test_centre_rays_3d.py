"""Exact blocking in 3D: what touches the ray through the middle of a link, and what shuts it."""

import numpy as np
import pytest
from links3d import L_SHAPE, ROUNDING, across_x, along, transmittance

#: On the link from (2, 1, 2) along x, whose ray is y = 1.5, z = 2.5.
RAY = (along(1, 0, 0), 2, 1, 2)


@pytest.mark.parametrize(
    ("wall", "covered"),
    [
        pytest.param(across_x(3, (1, 1.5), (2, 3)), 0.5, id="edge"),
        pytest.param(across_x(3, (1, 1.5), (2, 2.5)), 0.25, id="corner"),
        pytest.param([(3, 1.5, 2.5), (3, 1.2, 2.9), (3, 1.1, 2.6)], 0.065, id="corner of triangle"),
        pytest.param([(2.7, 1.5, 2), (3.2, 1, 2), (3.2, 1, 3), (2.7, 1.5, 3)], 0.5, id="slanted"),
    ],
)
def test_wall_that_touches_a_centre_ray_does_not_shut_it(wall, covered):
    assert transmittance(wall)[RAY] == pytest.approx(1 - covered, abs=1e-4)


def test_ridge_that_touches_a_centre_ray_does_not_shut_it():
    near = [(2.8, 1.2, 2), (2.8, 1.2, 3), (3, 1.5, 3), (3, 1.5, 2)]
    far = [(3.2, 1.2, 2), (3.2, 1.2, 3), (3, 1.5, 3), (3, 1.5, 2)]
    assert transmittance(near, far)[RAY] == pytest.approx(0.7, abs=ROUNDING)


def test_tip_of_a_pyramid_that_touches_a_centre_ray_does_not_shut_it():
    base = [(2.8, 1.1, 2.3), (3.2, 1.1, 2.3), (3.2, 1.1, 2.7), (2.8, 1.1, 2.7)]
    sides = [(base[i], base[i - 3], (3, 1.5, 2.5)) for i in range(4)]
    tau = transmittance(base, *sides)
    assert tau[RAY] == pytest.approx(1 - 0.5 * 0.4 * 0.4, abs=ROUNDING)


@pytest.mark.parametrize("shift", [0.0, 1e-10, -1e-10, 1e-8, -1e-8])
def test_walls_that_meet_on_a_centre_ray_shut_it(shift):
    low = [(3, 1.2, 2), (3.1, 1.5 + shift, 2), (3.1, 1.5 + shift, 3), (3, 1.2, 3)]
    high = [(3, 1.9, 2), (3.1, 1.5 + shift, 2), (3.1, 1.5 + shift, 3), (3, 1.9, 3)]
    assert transmittance(low, high)[RAY] == 0


def test_fan_of_triangles_round_a_centre_ray_shuts_it():
    angles = np.linspace(0, 2 * np.pi, 8)
    rim = np.stack(
        [3 + 0.1 * np.sin(3 * angles), 1.5 + 0.2 * np.cos(angles), 2.5 + 0.2 * np.sin(angles)]
    )
    fan = [(rim[:, i], rim[:, i + 1], (3, 1.5, 2.5)) for i in range(7)]
    assert transmittance(*fan)[RAY] == 0
    # All on one side of a plane through the ray: it passes beside them.
    half = [triangle for triangle in fan if max(p[1] for p in triangle) <= 1.5 + 1e-12]
    assert len(half) > 1
    assert transmittance(*half)[RAY] > 0.9


def test_wall_along_a_centre_ray_is_no_obstacle_to_it_until_another_leaves():
    floor = [(1, 0, 2.5), (4, 0, 2.5), (4, 5, 2.5), (1, 5, 2.5)]
    above = across_x(2.9, (0, 5), (2.5, 4))
    assert transmittance(floor)[RAY] == 1
    assert transmittance(above)[RAY] == 0.5
    assert transmittance(floor, above)[RAY] == 0


def test_light_runs_along_the_edge_of_a_box():
    lid = [(1, 1.5, 2.5), (5, 1.5, 2.5), (5, 4, 2.5), (1, 4, 2.5)]
    side = [(1, 1.5, 2.5), (5, 1.5, 2.5), (5, 1.5, 0), (1, 1.5, 0)]
    assert transmittance(lid, side)[RAY] == 1


def test_reflex_corner_round_a_centre_ray_shuts_it():
    """An L reaches round it by three quarters of a turn."""
    wall = np.insert((0.3 * (L_SHAPE - 1) + (1.5, 2.5)), 0, 3.0, axis=1)
    assert transmittance(wall)[RAY] == 0
