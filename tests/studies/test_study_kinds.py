"""Kinds that look at schemes alone, against what is known of them."""

from __future__ import annotations

import shlex
import subprocess
import sys

import numpy as np
import pytest
from small_studies import run_here, study_of

from flatland.harmonics import basis_for
from flatland.results import load_dataset
from propagators import create
from studies.kinds.growth import stops_up_to
from studies.kinds.waves import exact_response, wave_rows


def rows_of(tmp_path, **sweep):
    return load_dataset(run_here(study_of(sweep), tmp_path).dataset)


def test_known_radii(tmp_path):
    schemes = ["lpv", "lpv:flux=central", "dom4:emission=delta", "dom8:emission=delta"]
    data = rows_of(tmp_path, kind="radius", propagators=schemes, bands=5)
    np.testing.assert_allclose(data["radius"], [1, 0.967417, 4 / np.pi, 4 / np.pi], atol=1e-6)
    assert list(data["stable"].values) == [True, True, False, False]


def test_diffusion_answers_long_waves_with_the_inverse_square(tmp_path):
    """LPV: |λ| = 1 − D k² and response / |k|⁻² → constant; straight flight: |k|⁻¹."""
    stencil = create("lpv").stencil(basis_for(2, 4))
    waves = np.array([[0.02, 0.0], [0.04, 0.0]])
    first, second = wave_rows(stencil, waves)
    assert (1 - second["radius"]) / (1 - first["radius"]) == pytest.approx(4, rel=0.01)
    assert first["response"] / second["response"] == pytest.approx(4, rel=0.01)


@pytest.mark.parametrize(("bands", "power"), [(3, 2), (4, 0), (5, 2), (6, 0)])
def test_ordinates_with_bins_diffuse_if_the_number_of_bands_is_odd(bands, power):
    """With an even number the response to long waves stays finite, as in P_N of odd order."""
    stencil = create("dom8").stencil(basis_for(2, bands))
    first, second = wave_rows(stencil, np.array([[0.01, 0.0], [0.02, 0.0]]))
    assert first["response"] / second["response"] == pytest.approx(2**power, rel=0.01)


def test_straight_flight_counts_a_ray_in_every_cell_it_leaves():
    """Rays from a cell's middle, the cells they leave counted, one wave of the count.

    Fading by exp(−ε length) makes the sum finite and adds some 2 %. The exact answer for long
    waves is met to half a cell: the source's own, which light leaves from its middle.
    """
    rng, wave, fading, rays = np.random.default_rng(5), 0.2, 0.001, 1500
    total = 0.0
    for angle in 2 * np.pi * (np.arange(rays) + rng.uniform(size=rays)) / rays:
        x, y = np.cos(angle), np.sin(angle)
        reach = 6 / fading
        across = (np.arange(int(reach * abs(x))) + 0.5) / abs(x)
        along = (np.arange(int(reach * abs(y))) + 0.5) / abs(y)
        left_at = np.sort(np.concatenate([[0.0], across, along]))
        columns = np.rint((left_at[:-1] + left_at[1:]) / 2 * x)  # of the cell between two crossings
        total += np.sum(np.cos(wave * columns) * np.exp(-fading * left_at[1:]))
    exact = exact_response(np.array([wave, 0.0]))
    assert total / rays == pytest.approx(exact + 0.5, abs=0.15)


def test_measured_growth_nears_the_radius_from_below(tmp_path):
    scheme = "dom8:emission=delta"
    sweep = {"kind": "growth", "propagators": scheme, "bands": 5, "side": [8, 16, 32]}
    data = rows_of(tmp_path, **sweep, steps=400)
    wild = data.isel(row=data["wild"].values).sortby("side")
    growth = wild["growth"].values
    assert len(growth) >= 2
    assert np.all(np.diff(growth) > 0)
    assert np.all(growth < wild["radius"].values)
    assert growth[-1] > 1.23  # 4/π = 1.273
    assert np.all(data["finite"])


def test_both_precisions_fade_alike_and_keep_their_books(tmp_path):
    sweep = {"kind": "growth", "propagators": ["lpv", "dom8"], "side": 6, "steps": 50}
    data = rows_of(tmp_path, **sweep, precision=["float64", "float32"])
    doubles = data.isel(row=data["precision"].values == "float64")
    singles = data.isel(row=data["precision"].values == "float32")
    np.testing.assert_allclose(singles["norm"], doubles["norm"], rtol=1e-4)
    assert float(doubles["closure"].max()) < 1e-13
    assert float(singles["closure"].max()) < 1e-6


def test_between_perfect_mirrors_nothing_is_lost(tmp_path):
    sweep = {"kind": "growth", "propagators": "dom8", "start": "mirrors", "side": 4, "steps": 300}
    data = rows_of(tmp_path, **sweep)
    assert float(data["closure"].max()) < 1e-13
    assert float(data["norm"].values[-1]) > 0.3


@pytest.mark.parametrize("start", ["checkerboard", "lobe", "huge", "tiny", "row"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_every_start_runs(start, dimension, tmp_path):
    sweep = {"kind": "growth", "start": start, "dimension": dimension, "side": 3, "steps": 3}
    data = rows_of(tmp_path, **sweep, precision="float32")
    assert np.all(data["finite"])
    assert np.all(data["norm"] > 0)


def test_stops_are_decades():
    assert stops_up_to(1) == [1]
    assert stops_up_to(30) == [1, 2, 5, 10, 20, 30]
    assert stops_up_to(100_000)[-3:] == [20_000, 50_000, 100_000]


@pytest.mark.parametrize("kind", ["radius", "waves"])
def test_the_command_of_a_row_computes_it_again(kind, tmp_path):
    data = rows_of(tmp_path, kind=kind, propagators="lpv:flux=central", bands=5)
    program, *arguments = shlex.split(str(data["command"].values[-1]))
    assert program == "python"
    process = subprocess.run(
        [sys.executable, *arguments], check=True, capture_output=True, text=True
    )
    assert float(process.stdout) == pytest.approx(float(data["radius"].values[-1]), rel=1e-12)
