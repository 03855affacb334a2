"""Bars on a terminal, after a while; nothing in a pipe."""

import io
import time

import pytest

from propagators.watching import watcher
from studies import progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def terminal(monkeypatch):
    """What opens one: between a fixture and its test, pytest sets stderr anew."""

    def opened():
        screen = Terminal()
        monkeypatch.setattr("sys.stderr", screen)
        monkeypatch.setenv("TERM", "xterm")
        return screen

    return opened


def work():
    for share in (0.0, 0.5, 1.0, 0.25):
        watcher()(share)
        time.sleep(0.15)


def test_exact_answers_that_take_long_have_a_bar(terminal, monkeypatch):
    monkeypatch.setattr(progress, "_PATIENCE", 0.0)
    screen = terminal()
    with progress.answer_bar():
        work()
    assert "exact answer" in screen.getvalue()
    assert "50%" in screen.getvalue()
    assert "steps" not in screen.getvalue()


def test_steps_and_answers_have_bars_side_by_side(terminal, monkeypatch):
    monkeypatch.setattr(progress, "_PATIENCE", 0.0)
    screen = terminal()
    with progress.steps_bar(4) as done:
        done(1)
        work()
    assert "exact answer" in screen.getvalue()
    assert "steps" in screen.getvalue()


def test_quick_answers_have_none(terminal):
    screen = terminal()
    with progress.steps_bar(4) as done:
        done(4)
        watcher()(0.5)
        time.sleep(0.2)
    assert "exact" not in screen.getvalue()
    assert "steps" not in screen.getvalue()


def test_nothing_is_shown_in_a_pipe(monkeypatch):
    pipe = io.StringIO()
    monkeypatch.setattr("sys.stderr", pipe)
    with progress.steps_bar(4) as done:
        assert done is None
        watcher()(0.5)
    assert pipe.getvalue() == ""


def test_nobody_watches_afterwards(terminal):
    screen = terminal()
    with progress.answer_bar():
        pass
    shown = screen.getvalue()
    watcher()(0.5)
    assert screen.getvalue() == shown
