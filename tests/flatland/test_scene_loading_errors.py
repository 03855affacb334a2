"""Scenes that cannot be found, read or taken: every way ends in one InputError."""

import contextlib
import pickle
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flatland.errors import InputError
from flatland.scene import Scene, SceneError, builtin_text, load_scene, parse_scene


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("shelv", "did you mean 'shelf'?; built in: atrium, back-bleeding, checkerboard, clutter"),
        ("no/such/file.toml", "is neither a file nor a built-in scene"),
        ("shelf:size=3", "has no parameters"),
        ("clutter:sizes=3", "did you mean 'size'?; accepted: size, occluders, seed"),
        ("clutter:size=3", "must be a whole number from 16"),
        ("clutter:size=1e3", "must be a whole number from 16"),
        ("clutter:seed=-1", "must be a whole number from 0"),
        ("clutter:size", "must look like"),
        ("", "cannot be read"),
        (".", "cannot be read"),
        ("a\0b", "cannot be read"),
        ("x" * 5000, "cannot be read"),
        (5, "must be a name or a path"),
        (None, "must be a name or a path"),
    ],
)
def test_name_that_is_no_scene_is_refused(name, said):
    with pytest.raises(SceneError) as caught:
        load_scene(name)
    assert said in str(caught.value)


def test_unknown_name_of_a_builtin_text_is_refused():
    with pytest.raises(SceneError, match="did you mean 'corridor'"):
        builtin_text("coridor")


def test_unreadable_file_is_refused(tmp_path, monkeypatch):
    def refuse(*arguments, **keywords):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("pathlib.Path.open", refuse)
    with pytest.raises(SceneError, match="Permission denied"):
        load_scene(tmp_path / "scene.toml")


def test_huge_file_is_refused_unparsed(tmp_path):
    path = tmp_path / "huge.toml"
    with path.open("wb") as file:
        file.truncate(64 * 2**20 + 1)
    with pytest.raises(SceneError, match="larger than the 64 MiB"):
        load_scene(path)


@pytest.mark.parametrize("data", [5, None, [], "grid", {1: 2}, {"light": [{1: 2}]}, {"grid": None}])
def test_data_that_are_no_tables_are_refused(data):
    with pytest.raises(SceneError):
        Scene.from_dict(data)


def test_endless_data_are_refused():
    endless = []
    endless.append(endless)
    with pytest.raises(SceneError, match="nested too deeply"):
        Scene.from_dict({"grid": endless})


def test_error_survives_pickling():
    with pytest.raises(SceneError) as caught:
        load_scene("nope")
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


PIECES = """[grid]|[[light]]|[[occluder]]|[light]|shape = [|]|kind = |"area"|"wall"|"cell"|"file"
start = [1, 2]|end = [3, 2]|flux = |nan|5|9, |-1|{|}|=|.|side = 'left'|title = 1e9|file = 'x.npy'"""

words = st.sampled_from([piece + end for piece in re.split(r"[|\n]", PIECES) for end in ("", "\n")])

junk = st.one_of(st.text(), st.binary(), st.lists(words, max_size=30).map("".join))


@settings(deadline=None, derandomize=True, max_examples=300)
@given(junk)
def test_junk_is_refused_as_bad_input_or_is_a_scene(text):
    with contextlib.suppress(InputError):
        parse_scene(text)


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=3) | st.just("area"),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(["kind", "shape", "start", "flux", "cell"]), inner, max_size=4
        )
    ),
    max_leaves=12,
)


@settings(deadline=None, derandomize=True, max_examples=200)
@given(st.dictionaries(st.sampled_from(["title", "grid", "light", "occluder", "x"]), values))
def test_wrong_types_anywhere_are_refused_as_bad_input(data):
    with contextlib.suppress(InputError):
        Scene.from_dict({"grid": {"shape": [3, 3]}, **data})
