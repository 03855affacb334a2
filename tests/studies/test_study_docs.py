"""What docs/studies.md tells people to type."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import xarray as xr
from small_studies import run_here, small

from studies.command_line import COMMANDS
from studies.figures import FIGURES
from studies.kinds import KINDS, find_kind
from studies.sweeps.study import builtin_studies, parse_study

TEXT = (Path(__file__).parents[2] / "docs" / "studies.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", TEXT, re.DOTALL)


def test_the_study_of_the_page_has_the_cases_it_speaks_of():
    (text,) = (text for language, text in BLOCKS if language == "toml")
    study = parse_study(text.replace('"my-room.toml", ', ""), "page")
    cases = study.cases()
    assert {case.scene.name for case in cases} >= {"shelf", "box", "corridor"}
    assert {case.parameters["options"].get("emission") for case in cases} >= {"delta", None}


def test_the_five_lines_that_read_a_data_set_do(tmp_path, capsys):
    study = small("bands")
    run_here(study, tmp_path)
    path = str(tmp_path / "study.nc")
    lines = next(text for language, text in BLOCKS if "load_dataset" in text)
    lines = lines.replace("out/studies/bands/study.nc", path).replace('"shelf"', '"tiny"')
    exec(compile(lines, "page", "exec"), {})
    printed = capsys.readouterr().out
    data = xr.load_dataset(path, engine="h5netcdf")
    assert "dom8" in printed
    assert f"{float(np.round(data['angular'].values[0], 4)):.3f}"[:4] in printed


def test_the_python_of_the_page_runs_a_study(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code = next(text for language, text in BLOCKS if "run_study" in text)
    code = code.replace('"shelf"', '"two-walls"')
    exec(compile(code, "page", "exec"), {})
    assert (tmp_path / "out" / "studies" / "mine" / "study.nc").exists()


def test_every_key_kind_study_and_figure_it_names_exists():
    keys = set(re.findall(r"^\| (`.*?`) \|", TEXT, re.MULTILINE))
    named = {key.strip("` ") for entry in keys for key in entry.split(",")} - {"kind"}
    known = {axis.name for axis in find_kind("errors").axes} | {"scenes", "propagators"}
    assert named == known | set(find_kind("errors").lists)
    assert all(f"`{name}`" in TEXT for name in KINDS)
    for name in re.findall(r"flatland study ([a-z]+) ", TEXT):
        assert name in (*builtin_studies(), "list", "mine")
    for name in re.findall(r"flatland figure ([a-z]+) ([a-z]+)", TEXT):
        assert set(name) <= set(FIGURES)
    assert set(re.findall(r"flatland ([a-z]+)", TEXT)) <= set(COMMANDS)
