"""What a study's declaration means: its cases, their keys, and its mistakes."""

from __future__ import annotations

import numpy as np
import pytest
from small_studies import NAMES, TINY, every_builtin_study, study_of

from flatland.errors import InputError
from studies.sweeps import case as case_module
from studies.sweeps.study import builtin_studies, load_study, parse_study

SWEEP = {"scenes": "tiny", "propagators": ["lpv", "dom8"], "bands": [1, 2, 3], "converge": 1e-4}


def keys(study):
    return {case.key for case in study.cases()}


def one(**changes):
    """The only case of a sweep."""
    (case,) = study_of({"scenes": "tiny", "bands": 2, **changes}).cases()
    return case


def test_a_sweep_is_the_product_of_its_lists():
    cases = study_of({**SWEEP, "precision": ["float64", "float32"]}).cases()
    assert len(cases) == 2 * 3 * 2
    seen = {
        (c.parameters["propagator"], c.parameters["bands"], c.parameters["precision"])
        for c in cases
    }
    assert len(seen) == 12


def test_sweeps_that_overlap_share_their_cases():
    both = study_of(SWEEP, {**SWEEP, "bands": [3, 4]})
    assert len(both.cases()) == 2 * 4


@pytest.mark.parametrize(
    "changes",
    [
        {"bands": 3},
        {"propagators": "dom4"},
        {"propagators": "lpv:flux=central"},
        {"precision": "float32"},
        {"blocking": "none"},
        {"bounces": False},
        {"lights_block": True},
        {"converge": 1e-3},
        {"iterations": 3},
        {"resolution": 2},
        {"scenes": "shelf"},
        {"repeats": 2},
    ],
)
def test_every_setting_changes_the_key(changes):
    assert one().key != one(**changes).key


def test_what_changes_nothing_changes_no_key():
    assert one().key == one(strength=3.0).key  # exact blocking has no strength
    assert one().key == one(iterations="2N").key  # the default
    assert one().key == one(iterations=[12]).key
    assert (
        one(propagators={"name": "lpv", "flux": "central"}).key
        == one(propagators="lpv:flux=central").key
    )
    assert one(propagators="analytic").key == one(propagators="analytic", precision="float32").key


def test_the_key_follows_the_content_of_a_scene_not_its_name():
    renamed = study_of({"scenes": "other", "bands": 2}, other=TINY)
    assert keys(renamed) == {one().key}
    brighter = {**TINY, "light": [{**TINY["light"][0], "flux": 4.0}]}
    assert keys(study_of({"scenes": "tiny", "bands": 2}, tiny=brighter)) != {one().key}


def test_the_key_follows_data_files(tmp_path):
    scene = tmp_path / "a.toml"
    scene.write_text('[grid]\nshape = [4, 4]\n[[light]]\nkind = "file"\nfile = "a.npy"\n')
    found = []
    for value in (1.0, 2.0, 1.0):
        np.save(tmp_path / "a.npy", np.full((1, 4, 4), value))
        found.append(keys(study_of({"scenes": str(scene)})))
    assert found[0] == found[2] != found[1]


def test_the_key_follows_the_code(monkeypatch):
    before = one().key
    monkeypatch.setattr(case_module, "code_version", lambda: "0.1.0+other")
    assert one().key != before


def test_multiples_of_the_longest_side():
    stops = one(iterations=[0, "N", "0.5N", "2N", 6]).parameters["iterations"]
    assert stops == [0, 3, 6, 12]  # N = 6


def test_all_scenes_and_all_schemes():
    study = study_of({"scenes": "all-2d", "propagators": "all", "bands": 2})
    names = {case.scene.name for case in study.cases()}
    assert {"shelf", "clutter", "fig5-one-light"} <= names
    schemes = {case.parameters["propagator"] for case in study.cases()}
    assert {"lpv", "lpv-2009", "dom4", "dom8"} <= schemes
    assert not schemes & {"dom6", "dom26", "analytic"}


def test_variants_are_all_different_stencils():
    study = study_of({"kind": "radius", "propagators": "all-variants", "bands": 5})
    cases = study.cases()
    assert len({case.key for case in cases}) == len(cases) > 10


@every_builtin_study
def test_a_study_survives_being_written(name):
    study = load_study(name)
    assert keys(parse_study(study.to_toml(), name)) == keys(study)


def test_the_list_of_built_in_studies_is_tested_in_full():
    assert sorted(NAMES) == builtin_studies()


@pytest.mark.parametrize(
    ("sweep", "words"),
    [
        ({"scenes": "tiny", "band": 2}, ["'band'", "unknown key", "bands"]),
        ({"scenes": "tiny", "bands": 0}, ["bands = 0", "at least 1"]),
        ({"scenes": "tiny", "bands": []}, ["bands", "empty"]),
        ({"scenes": "tiny", "propagators": "lvp"}, ["lvp", "dom8"]),
        ({"scenes": "tiny", "propagators": "lpv:flux=soft"}, ["flux", "soft", "central"]),
        ({"scenes": "tiny", "propagators": "dom26"}, ["no propagator fits"]),
        ({"scenes": "tiny", "propagators": 3}, ["propagators = 3", "name:key=value"]),
        ({"scenes": "tiny", "iterations": "2M"}, ["iterations", "2M", "2N"]),
        ({"scenes": "tiny", "iterations": [-1]}, ["iterations", "-1"]),
        ({"scenes": "tiny", "converge": 2.0}, ["converge", "between 0 and 1"]),
        ({"scenes": "nowhere"}, ["nowhere", "shelf"]),
        ({"scenes": "back-bleeding", "resolution": 2}, ["resolution = 2", "back-bleeding", "odd"]),
        ({"bands": 2}, ["scenes", "all-2d"]),
        ({"kind": "magic"}, ["magic", "errors", "growth"]),
        ({"kind": "radius", "scenes": "tiny"}, ["'scenes'", "unknown key"]),
        ({"kind": "growth", "start": "sun"}, ["start", "sun", "random"]),
    ],
)
def test_a_mistake_is_named_with_its_place_and_the_choices(sweep, words):
    with pytest.raises(InputError) as caught:
        study_of(SWEEP, sweep).cases()
    assert "sweep 2" in str(caught.value)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("sweep = 3", ["sweep = 3"]),
        ("[[sweeps]]", ["'sweeps'", "unknown key"]),
        ("title = [", ["not valid TOML"]),
        ("scene = 3", ["scene = 3"]),
        ("title = 3", ["title = 3"]),
        ("title = 'x'", ["no [[sweep]]"]),
    ],
)
def test_a_file_that_is_no_study_is_refused(text, words):
    with pytest.raises(InputError) as caught:
        parse_study(text, "try").cases()
    for word in words:
        assert word in str(caught.value)
