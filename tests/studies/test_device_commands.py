"""`--device`: what commands say of it, and what is kept."""

import json
import sys

import pytest
from click.testing import CliRunner
from host_cupy import HostCupy
from on_device import stand_in
from scenes import scene_of

from flatland.errors import InputError
from flatland.results import load_dataset
from propagators import create
from studies.commands.compare import command as compare
from studies.commands.run import command as run
from studies.running import Method, run_method


def output(command, *arguments):
    result = CliRunner().invoke(command, arguments)
    if result.exception is not None:
        raise result.exception
    return result.stdout


def test_a_run_says_what_stepped_it(monkeypatch, tmp_path):
    stand_in(monkeypatch)
    kept = tmp_path / "kept.nc"
    arguments = ("shelf", "--iterations", "5", "--device", "cuda")
    assert " s on stand-in\n" in output(run, *arguments, "-o", str(kept))
    assert json.loads(load_dataset(kept).attrs["method"])["device"] == "cuda"
    record = json.loads(output(run, *arguments, "--json"))
    assert record["device"] == "stand-in"
    assert record["method"]["device"] == "cuda"
    here = json.loads(output(run, *arguments[:3], "--json"))
    assert here["ledger"] == {
        name: pytest.approx(value, rel=1e-12, abs=1e-12) for name, value in record["ledger"].items()
    }
    assert "device" not in here["method"]


def test_comparing_on_a_device(monkeypatch):
    stand_in(monkeypatch)
    arguments = ("fig5-one-light", "--bands", "2", "--propagator", "lpv", "--json")
    there = json.loads(output(compare, *arguments, "--device", "cuda"))["runs"][0]
    here = json.loads(output(compare, *arguments))["runs"][0]
    assert there["method"]["device"] == "cuda"
    assert there["errors"] == pytest.approx(here["errors"], rel=1e-6)


@pytest.mark.parametrize("command", [run, compare])
def test_no_device_is_said_before_anything_is_computed(monkeypatch, command):
    monkeypatch.setitem(sys.modules, "cupy", HostCupy(devices=0))
    with pytest.raises(InputError, match="there is no CUDA device; accepted: cpu"):
        output(command, "shelf", "--device", "cuda")


def test_direct_methods_have_no_device():
    method = Method(create("analytic"), device="cuda")
    with pytest.raises(InputError, match="device = 'cuda': must be cpu: analytic does not step"):
        run_method(scene_of(), method)
