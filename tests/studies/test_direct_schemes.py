"""Schemes that do not step, by the registry alone: on the command line and in studies."""

import csv
import json

import numpy as np
import pytest
from click.testing import CliRunner
from small_studies import TINY, Silent, run_here, study_of

import propagators
from flatland.results import load_dataset
from flatland.scene import Scene, scene_to_toml
from studies.command_line import flatland

DIRECT = [
    name
    for name in propagators.names()
    if issubclass(propagators.find(name), propagators.DirectPropagator)
]


def printed(*arguments):
    result = CliRunner().invoke(flatland, [str(each) for each in arguments])
    assert result.exit_code == 0, result.output
    return result.stdout


def test_there_are_some():
    assert {"beam", "sn", "lattice-boltzmann", "modified-dom"} <= set(DIRECT)


def test_compare_takes_them_all(tmp_path):
    path = tmp_path / "tiny.toml"
    path.write_text(scene_to_toml(Scene.from_dict(TINY)))
    asked = [word for name in DIRECT for word in ("--propagator", name)]
    record = json.loads(printed("compare", path, "--bands", 3, "--json", *asked))
    assert [run["method"]["propagator"] for run in record["runs"]] == DIRECT
    assert not record["failed"]
    errors = {run["method"]["propagator"]: run["errors"]["coefficients"] for run in record["runs"]}
    assert errors["modified-dom"] < 1e-12  # black walls
    assert errors["beam"] < errors["sn"] < errors["lattice-boltzmann"]


def test_a_study_takes_them_all_with_options(tmp_path):
    asked = [*DIRECT, "beam:ordinates=64", {"name": "sn", "rule": "diamond"}]
    study = study_of({"scenes": "tiny", "propagators": asked, "bands": [2, 3]})
    outcome = run_here(study, tmp_path / "study", Silent())
    assert (outcome.done, outcome.failed) == (2 * len(asked), [])
    data = load_dataset(outcome.dataset)
    assert set(data["propagator"].values) == set(DIRECT)
    assert set(data["stop"].values) == {"direct"}
    keeps = data["propagator"].values != "holographic-rc"
    assert np.all(np.abs(data["closure"].values[keeps]) < 1e-12 * TINY["light"][0]["flux"])
    assert np.all(data["medium"].values[keeps] == 0)
    with (tmp_path / "study" / "study.csv").open(newline="", encoding="utf-8") as text:
        commands = {row["command"] for row in csv.DictReader(text)}
    assert any("--propagator lattice-boltzmann" in command for command in commands)
    assert any("--option rule=diamond" in command for command in commands)


def test_a_study_in_a_medium_books_it(tmp_path):
    fog = {**TINY, "medium": {"extinction": 0.8, "albedo": 0.5}}
    table = {"scenes": "fog", "propagators": ["dom8", "beam"], "reference": False}
    outcome = run_here(study_of(table, fog=fog), tmp_path, Silent())
    data = load_dataset(outcome.dataset)
    assert np.all(data["medium"].values > 0.3)
    assert np.all(np.abs(data["closure"].values) < 1e-11)


def test_a_run_in_a_medium_prints_its_books(tmp_path):
    path = tmp_path / "fog.toml"
    fog = {**TINY, "medium": {"extinction": 0.8, "albedo": 0.5}}
    path.write_text(scene_to_toml(Scene.from_dict(fog)))
    text = printed("run", path, "--propagator", "lattice-boltzmann")
    assert "medium [W]" in text
    assert "probability 0.7" in text


def test_comparing_in_a_medium_says_that_no_exact_answer_knows_one(tmp_path):
    path = tmp_path / "fog.toml"
    path.write_text(scene_to_toml(Scene.from_dict({**TINY, "medium": {"extinction": 0.8}})))
    result = CliRunner().invoke(flatland, ["compare", str(path), "--propagator", "beam"])
    assert result.exit_code != 0
    with pytest.raises(Exception, match="analytic knows a vacuum only; these know a medium"):
        raise result.exception
