"""What is kept between sittings may be damaged without harm."""

from __future__ import annotations

import json
import os

import pytest

from gui.models.display import HEAT, Look, look_from
from gui.models.document import SceneDocument
from gui.models.recovery import Recovery
from gui.models.settings import MOST_RECENT, Settings

DAMAGED = [
    b"", b"{", b"[]", b"null", b"\xff\xfe\x00", b'{"look": 3}',
    b'{"look": {"views": ["nonsense"]}}',
    b'{"theme": [1], "recent": {"a": 1}, "layout": "no base64!", "geometry": 7}',
    b'{"recent": [1, null, "", "shelf"], "look": {"decades": NaN, "rate": -1, "heat": "x"}}',
    b"[" * 100_000,
]  # fmt: skip


@pytest.mark.parametrize("content", DAMAGED)
def test_damaged_settings_are_as_if_never_stored(tmp_path, content):
    path = tmp_path / "desktop.json"
    path.write_bytes(content)
    settings = Settings(path)
    assert settings.look == Look()
    assert settings.theme == "system"
    assert settings.recent in ([], ["shelf"])
    assert settings.stored_bytes("layout") == b""
    settings.opened("fig5-one-light")
    assert settings.save()
    assert Settings(path).recent[0] == "fig5-one-light"


def test_settings_come_back(tmp_path):
    path = tmp_path / "folder" / "desktop.json"
    settings = Settings(path)
    look = Look(views=("accumulated",), scale="linear", heat=HEAT[1], decades=6.0, rate=None)
    settings.keep_look(look)
    settings.theme = "dark"
    settings.store_bytes("layout", b"\x00\x01")
    for number in range(20):
        settings.opened(f"scene {number}")
    settings.opened("scene 15")
    assert settings.save()
    again = Settings(path)
    assert again.look == look
    assert again.theme == "dark"
    assert again.stored_bytes("layout") == b"\x00\x01"
    assert again.recent[:2] == ["scene 15", "scene 19"]
    assert len(again.recent) == MOST_RECENT


def test_a_folder_that_cannot_be_written_is_no_disaster(tmp_path):
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    settings = Settings(tmp_path / "file" / "desktop.json")
    assert not settings.save()


def test_looks_are_read_value_by_value():
    stored = {"views": ["target"], "scale": "cubic", "decades": 3.0, "top": 5.0, "new": 1}
    assert look_from(stored) == Look(views=("target",), decades=3.0)


def test_a_crash_loses_no_scene(tmp_path, monkeypatch):
    document = SceneDocument.open("shelf")
    recovery = Recovery(document, tmp_path)
    assert not recovery.keep()
    document.set_text("# mine\n" + document.text)
    assert recovery.keep()
    assert not recovery.keep()
    assert recovery.lost() == []  # this process lives
    record = json.loads(recovery.file.read_text(encoding="utf-8"))
    gone = tmp_path / "unsaved-1.json"
    record["process"] = _dead_process()
    gone.write_text(json.dumps(record), encoding="utf-8")
    (tmp_path / "unsaved-2.json").write_text("{damaged", encoding="utf-8")
    lost = recovery.lost()
    assert [each.text for each in lost] == [document.text]
    assert lost[0].origin.name == "shelf"
    recovery.forget()
    assert not recovery.file.exists()


def _dead_process():
    import subprocess
    import sys

    process = subprocess.Popen([sys.executable, "-c", "pass"])
    process.wait()
    return process.pid


def test_a_lost_scene_is_offered_at_the_start(make, answers, tmp_path):
    from gui.autosave import AutoSave

    window = make()
    other = SceneDocument.open("shelf")
    other.set_text("# mine\n" + other.text)
    Recovery(other, tmp_path).keep()
    record = json.loads((tmp_path / f"unsaved-{os.getpid()}.json").read_text(encoding="utf-8"))
    record["process"] = _dead_process()
    (tmp_path / "unsaved-9.json").write_text(json.dumps(record), encoding="utf-8")
    saver = AutoSave(window, tmp_path)
    assert saver.offer()
    assert window.session.document.text == other.text
    assert window.session.document.dirty
    assert not saver.offer()
