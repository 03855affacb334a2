"""The exact answer beside a run: what is asked for, taken, and dropped as too late."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flatland.field import Field
from flatland.harmonics import CircularHarmonics
from gui.models.document import SceneDocument
from gui.models.session import Session


class Jobs:
    """A runner that only writes down."""

    waiting = 0

    def __init__(self):
        self.asked, self.cancelled = [], 0

    def submit(self, job):
        self.asked.append(job)

    def cancel(self):
        self.cancelled += 1


@pytest.fixture
def session():
    session = Session(SceneDocument.open("fig5-one-light"))
    session.runner, session.reference.runner = Jobs(), Jobs()
    return session


@pytest.fixture
def reference(session):
    return session.reference


def answer(job):
    basis = CircularHarmonics(job.choice.bands)
    return Field(job.scene.grid, basis, np.ones((basis.size, *job.scene.grid.shape)))


def other_bands(session):
    session.choose(replace(session.choice, bands=session.choice.bands + 1))


def other_method(session):
    session.choose(replace(session.choice, propagator="dom8"))


def test_an_answer_is_taken_and_measured_against(session, reference):
    reference.compute()
    reference.compute()
    (job,) = reference.runner.asked
    assert reference.computing
    exact = answer(job)
    reference.take(job, exact)
    assert not reference.computing
    assert session.exact is exact
    measured = [job for job in session.runner.asked if job.kind == "measure"]
    assert [job.arguments["exact"] for job in measured] == [exact]
    reference.compute()
    assert reference.runner.asked == [job]


def test_an_answer_that_comes_after_a_stop_is_dropped(session, reference):
    reference.compute()
    reference.stop()
    assert not reference.computing
    assert reference.runner.cancelled == 1
    (job,) = reference.runner.asked
    reference.take(job, answer(job))
    assert session.exact is None
    reference.compute()
    assert len(reference.runner.asked) == 2


def test_one_that_was_stopped_does_not_end_the_next(session, reference):
    """The word that the first was cancelled comes when the second is under way."""
    reference.compute()
    reference.stop()
    reference.compute()
    first, second = reference.runner.asked
    reference.take(first, None)
    assert reference.computing
    reference.take(second, answer(second))
    assert session.exact is not None


def test_other_bands_need_another_answer(session, reference):
    reference.compute()
    other_bands(session)
    first, second = reference.runner.asked
    assert reference.runner.cancelled == 1
    reference.take(first, answer(first))
    assert session.exact is None
    reference.take(second, answer(second))
    assert session.exact.basis.bands == session.choice.bands
    other_bands(session)
    assert session.exact is None


def test_edits_without_an_exact_answer_tell_nobody(session):
    told = []
    session.references_changed.connect(lambda: told.append(1))
    other_bands(session)
    other_method(session)
    assert not told


def test_another_method_goes_on_with_the_same_answer(session, reference):
    reference.compute()
    other_method(session)
    (job,) = reference.runner.asked
    assert reference.runner.cancelled == 0
    reference.take(job, answer(job))
    exact = session.exact
    assert exact is not None
    other_bands(session)
    assert session.exact is None


def test_what_cannot_be_had_is_not_asked_for_again_and_again(reference):
    reference.compute()
    (job,) = reference.runner.asked
    reference.take(job, None)
    assert not reference.computing
    assert reference.runner.asked == [job]
