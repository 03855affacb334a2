"""Propagators by name, and plug-ins of other projects."""

import json
import os
import subprocess
import sys
import textwrap

import pytest

import propagators
from flatland.errors import InputError
from propagators import registry

GOOD = """
    import numpy as np
    from flatland.stencil import Stencil
    from propagators import Option, StencilPropagator

    class Fading(StencilPropagator):
        name = "fading"
        summary = "one band of light, part of which dies at every step"
        options = (Option("kept", float, 0.5, "share that lives", minimum=0.0, maximum=1.0),)

        def _build(self, basis):
            offsets = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
            share = self.values["kept"] / 4
            return Stencil(basis, offsets, np.tile(share * np.eye(basis.size), (4, 1, 1)))
"""
USE = """
    import json, propagators
    from flatland import Scene, Simulation
    light = {"kind": "cell", "cell": [3, 3], "flux": 1.0}
    scene = Scene.from_dict({"grid": {"shape": [7, 7]}, "light": [light]})
    simulation = Simulation(scene, propagators.create("fading", kept="0.25"), bands=1)
    simulation.run(2)
    inside = float(simulation.ledger.inside)
    print(json.dumps({"names": propagators.names(), "inside": inside}))
"""
BROKEN = {
    "import error": ("import a_module_that_is_not_there", "Fading", "ModuleNotFoundError"),
    "syntax error": ("class", "Fading", "SyntaxError"),
    "exit on import": ("raise RuntimeError('no licence')", "Fading", "RuntimeError: no licence"),
    "no such class": ("Other = 1", "Fading", "AttributeError"),
    "not a class": ("Fading = 3", "Fading", "offers 3, not a Propagator class"),
    "another class": ("class Fading: pass", "Fading", "not a Propagator class"),
    "nothing to solve with": (
        "from propagators import Propagator\nclass Fading(Propagator): name = 'fading'",
        "Fading",
        "Fading lacks solve",
    ),
}


def install(folder, source, attribute="Fading", module="plug_in_under_test"):
    """What pip leaves behind of a project with one entry point, without pip."""
    (folder / f"{module}.py").write_text(textwrap.dedent(source), encoding="utf-8")
    info = folder / f"{module}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n")
    lines = f"[{registry.ENTRY_POINT_GROUP}]\nfading = {module}:{attribute}\n"
    (info / "entry_points.txt").write_text(lines)


@pytest.fixture
def plug_in(tmp_path, monkeypatch):
    """A function that installs a plug-in into this process, for the time of a test."""
    monkeypatch.syspath_prepend(tmp_path)
    registry._third_party.cache_clear()

    def put(source, attribute="Fading"):
        install(tmp_path, source, attribute)
        sys.modules.pop("plug_in_under_test", None)
        registry._third_party.cache_clear()

    yield put
    sys.modules.pop("plug_in_under_test", None)
    registry._third_party.cache_clear()


def test_our_propagators_come_first():
    ours = ["lpv", "lpv-2009", "dom4", "dom8", "dom6", "dom26", "analytic"]
    assert propagators.names()[: len(ours)] == ours


@pytest.mark.parametrize("name", propagators.names())
def test_every_name_leads_to_its_class(name):
    found = propagators.find(name)
    assert found.name == name
    assert found.summary
    assert isinstance(propagators.create(name), found)


@pytest.mark.parametrize("name", ["LPV", "", "lpv ", "dom16"])
def test_unknown_name_lists_the_names(name):
    with pytest.raises(InputError) as caught:
        propagators.create(name)
    known = ", ".join(propagators.names())
    assert str(caught.value) == f"propagator = {name!r}: is unknown; accepted: {known}"


def test_listing_names_imports_no_scheme():
    """A command line that offers names must not wait for numerics it does not run."""
    script = "import sys, propagators; propagators.names(); print('propagators.dom' in sys.modules)"
    assert run_python(script).strip() == "False"


def test_installed_plug_in_is_a_propagator_like_ours(tmp_path):
    """Two steps that keep a quarter each leave a sixteenth of the light."""
    install(tmp_path, GOOD)
    answer = json.loads(run_python(textwrap.dedent(USE), tmp_path))
    assert answer["names"][-1] == "fading"
    assert answer["inside"] == pytest.approx(1 / 16, rel=1e-12)


@pytest.mark.parametrize(("source", "attribute", "reason"), BROKEN.values(), ids=BROKEN)
def test_broken_plug_in_is_reported_as_one(source, attribute, reason, plug_in):
    plug_in(source, attribute)
    with pytest.raises(InputError) as caught:
        propagators.create("fading")
    assert str(caught.value).startswith("propagator = 'fading': its plug-in")
    assert reason in str(caught.value)


def test_broken_plug_in_does_not_hide_the_others(plug_in):
    plug_in("raise RuntimeError")
    assert "fading" in propagators.names()
    assert propagators.create("lpv").name == "lpv"


def test_plug_in_cannot_replace_one_of_ours(tmp_path, plug_in):
    plug_in(GOOD)
    points = tmp_path / "plug_in_under_test-1.0.dist-info" / "entry_points.txt"
    points.write_text(points.read_text().replace("fading =", "lpv ="))
    registry._third_party.cache_clear()
    assert propagators.names().count("lpv") == 1
    assert propagators.find("lpv").__module__ == "propagators.lpv"


def run_python(script, *folders):
    """What a fresh interpreter prints; folders are searched for installed projects first."""
    path = os.pathsep.join(map(str, [*folders, *filter(None, sys.path)]))
    environment = {**os.environ, "PYTHONPATH": path}
    command = [sys.executable, "-W", "error", "-c", script]
    return subprocess.run(
        command, env=environment, check=True, capture_output=True, text=True, timeout=60
    ).stdout
