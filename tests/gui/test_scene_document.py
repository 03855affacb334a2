"""Edits of scene texts keep what they do not speak of; documents hold valid scenes alone."""

from __future__ import annotations

import tomllib

import pytest

from flatland.scene import SceneError, builtin_names, builtin_text
from gui.models import edits
from gui.models.document import Origin, SceneDocument
from gui.models.toml_text import REMOVED, insert_tables, remove_tables, tables_of, update_table

CORNELL = builtin_text("cornell-2d")


def comments(text):
    return [line for line in text.splitlines() if line.lstrip().startswith("#")]


def test_changing_a_value_changes_its_line_alone():
    text = update_table(CORNELL, ("light", 0), {"start": [19.0, 30.0]})
    changed = [a for a, b in zip(CORNELL.splitlines(), text.splitlines()) if a != b]
    assert changed == ["start = [20.0, 31.0]"]
    assert tables_of(text)["light"][0]["start"] == [19.0, 30.0]


def test_a_new_key_stands_with_its_table():
    text = update_table(CORNELL, ("light", 0), {"radiance": REMOVED, "flux": 3.0})
    lines = text.splitlines()
    assert lines[lines.index("flux = 3.0") - 1] == "end = [12.0, 31.0]"
    assert comments(text) == comments(CORNELL)


def test_a_comment_behind_a_value_stays():
    text = 'title = "a"\n[grid]\nshape = [4, 4]   # cells\nspacing = 1.0 # m\n'
    changed = update_table(text, ("grid",), {"shape": [8, 8]})
    assert changed == text.replace("[4, 4]", "[8, 8]")


def test_removing_an_item_takes_its_own_comment_along():
    text = remove_tables(CORNELL, [("occluder", 0)])
    assert "# Left wall, red." not in text
    assert "# Right wall, green." in text
    assert len(tables_of(text)["occluder"]) == len(tables_of(CORNELL)["occluder"]) - 1


def test_adding_an_item_keeps_every_line():
    text = insert_tables(CORNELL, "light", [{"kind": "cell", "cell": [1, 2], "flux": 1.0}])
    assert comments(text) == comments(CORNELL)
    assert tables_of(text)["light"][1] == {"kind": "cell", "cell": [1, 2], "flux": 1.0}


def test_an_edit_that_changes_nothing_is_the_same_text():
    assert update_table(CORNELL, ("grid",), {"shape": (32, 32)}) == CORNELL


@pytest.mark.parametrize("name", builtin_names())
def test_every_built_in_scene_survives_all_edits(name):
    text = builtin_text(name)
    tables = tables_of(text)
    for key in ("light", "occluder"):
        for index in range(len(tables.get(key, []))):
            removed = tables_of(edits.remove(text, [(key, index)]))
            kept = [t for i, t in enumerate(tables[key]) if i != index]
            assert removed.get(key, []) == kept
    assert "light" not in tables_of(edits.clear(text, "light"))
    assert tables_of(edits.clear(text, "light")).get("occluder") == tables.get("occluder")


def test_strange_layouts_are_edited_too():
    text = (
        "grid.shape = [4, 4]\n"
        'light = [{kind = "cell", cell = [1, 1], flux = 1.0}]\n'
        '[[occluder]]\nkind = "segment"\nstart = [0.0, 0.0]\nend = [1.0, 1.0]\n'
    )
    more = insert_tables(text, "light", [{"kind": "cell", "cell": [2, 2], "flux": 2.0}])
    assert [t["cell"] for t in tables_of(more)["light"]] == [[1, 1], [2, 2]]
    assert tables_of(remove_tables(text, [("light", 0)])).get("light") is None
    moved = update_table(text, ("grid",), {"shape": [6, 6]})
    assert tables_of(moved)["grid"] == {"shape": [6, 6]}


def test_text_in_strings_fools_no_edit():
    text = 'title = """\n[[light]]\nflux = 3\n"""\n[grid]\nshape = [4, 4]\n'
    added = insert_tables(text, "light", [{"kind": "cell", "cell": [1, 1], "flux": 1.0}])
    assert tables_of(added)["title"] == tomllib.loads(text)["title"]
    assert len(tables_of(added)["light"]) == 1


def test_a_document_refuses_what_is_no_scene():
    document = SceneDocument.open("shelf")
    before = document.text, document.scene
    with pytest.raises(SceneError, match="spacing"):
        document.set_text(document.text.replace("[grid]", "[grid]\nspacing = -1.0"))
    assert (document.text, document.scene) == before


def test_saving_keeps_the_text_and_clears_the_mark(tmp_path):
    document = SceneDocument.open("shelf")
    assert not document.dirty
    document.set_text("# mine\n" + document.text)
    assert document.dirty
    path = document.save(tmp_path / "mine.toml")
    assert path.read_text(encoding="utf-8") == document.text
    assert not document.dirty
    assert document.origin.path == path
    again = SceneDocument.open(path)
    assert again.scene == document.scene


def test_a_file_with_a_byte_order_mark_opens(tmp_path):
    path = tmp_path / "windows.toml"
    path.write_bytes(b"\xef\xbb\xbf[grid]\r\nshape = [4, 4]\r\n")
    assert SceneDocument.open(path).scene.grid.shape == (4, 4)


def test_a_bad_file_leaves_the_document_alone(tmp_path):
    document = SceneDocument.open("shelf")
    bad = tmp_path / "bad.toml"
    bad.write_text("[grid]\nshape = [0, 4]\nspacing = 'a'\n", encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        document.load(bad)
    assert len(caught.value.problems) == 2
    assert document.origin == Origin("shelf", directory=document.origin.directory)
