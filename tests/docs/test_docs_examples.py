"""The examples of docs/extending.md do what they say."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import displacement
import numpy as np
import pytest
from block import BlockLight
from fog import Fog
from triangle import TriangleOccluder
from turned import turned

import flatland
import propagators
from flatland.errors import InputError
from flatland.field import Field
from flatland.harmonics import basis_for
from studies.style import figure_style

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("bands", [1, 2, 5])
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_fog_keeps_flux_and_is_stable(bands, share):
    stencil = Fog(share=share).stencil(basis_for(2, bands))
    np.testing.assert_allclose(stencil.flux_gain, np.eye(2 * bands - 1)[0], atol=1e-14)
    assert stencil.spectral_radius() == pytest.approx(1.0, abs=1e-9)


def test_clear_fog_is_dom8():
    basis = basis_for(2, 4)
    dom8 = propagators.create("dom8").stencil(basis)
    np.testing.assert_array_equal(Fog(share=0).stencil(basis).transfer, dom8.transfer)


def test_fog_balances_its_books_on_a_scene():
    simulation = flatland.Simulation(flatland.load_scene("shelf"), Fog(share=0.4), bands=3)
    simulation.run(20)
    books = simulation.ledger
    assert float(books.closure) == pytest.approx(0.0, abs=1e-11 * float(books.emitted))
    assert abs(float(books.created)) < 1e-12 * float(books.emitted)


def test_fog_refuses_a_share_above_one():
    with pytest.raises(InputError, match=r"share = 2: must be at most 1"):
        Fog(share=2)


def test_fog_as_a_project_of_its_own_runs_by_name(tmp_path):
    """Its file and its entry point, as pip leaves them; then the command line."""
    (tmp_path / "fog.py").write_bytes((ROOT / "docs" / "examples" / "fog.py").read_bytes())
    info = tmp_path / "flatland_fog-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: flatland-fog\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[flatland.propagators]\nfog = fog:Fog\n")
    script = "from studies.command_line import main; main()"
    words = ["run", "two-walls", "--propagator", "fog", "--option", "share=0.5", "--json"]
    path = os.pathsep.join(map(str, [tmp_path, ROOT, *filter(None, sys.path)]))
    done = subprocess.run(
        [sys.executable, "-c", script, *words],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(done.stdout)["method"]["options"] == {"share": 0.5}


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_block_light_is_the_same_light_for_cells_and_for_the_reference(dimension):
    light = BlockLight(low=(1,) * dimension, high=(2,) * dimension, flux=6.0)
    grid, basis = flatland.Grid((5,) * dimension), basis_for(dimension, 3)
    pattern = Field(grid, basis, light.inject(grid, basis))
    assert float(pattern.total_flux()) == pytest.approx(1.0, rel=1e-14)
    lit = np.argwhere(pattern.scalar_flux() > 0) + 0.5
    sources = light.sources(grid)
    np.testing.assert_allclose(lit, [source.position for source in sources])
    assert sum(source.spectrum.sum() for source in sources) == pytest.approx(6.0)


def test_a_triangle_is_closed_and_equilateral():
    walls = TriangleOccluder(center=(2.0, 3.0), radius=1.5, albedo=0.5).walls()
    for wall, following in zip(walls, [*walls[1:], walls[0]]):
        np.testing.assert_array_equal(wall.stop, following.start)
        assert np.linalg.norm(wall.stop - wall.start) == pytest.approx(1.5 * np.sqrt(3))


def test_turned_measures_the_angle_by_which_a_field_is_turned():
    grid, basis = flatland.Grid((3, 2)), basis_for(2, 4)
    angles = np.linspace(0, 2, 6).reshape(3, 2)

    def lobes(angle):
        normals = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        return Field(grid, basis, np.moveaxis(basis.lambertian(normals), -1, 0))

    assert turned(lobes(angles), lobes(angles)) == pytest.approx(0.0, abs=1e-7)
    assert turned(lobes(angles + 0.3), lobes(angles)) == pytest.approx(0.3)
    assert np.isnan(turned(lobes(angles).with_bands(1), lobes(angles).with_bands(1)))


def test_the_figure_shows_what_the_tutorial_says():
    """LPV's light stops at 1.599 cells (numerics §3); DOM8's keeps going."""
    data = displacement.compute(None)
    rows = data["rows"].to_dataframe().set_index(["scheme", "steps"])["mean"]
    assert rows["lpv", 32] == pytest.approx(1.5991, abs=2e-4)
    assert rows["dom8", 48] > 40
    with figure_style():
        figure = displacement.draw(data)[""]
    assert len(figure.axes[0].lines) == 2
