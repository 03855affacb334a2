"""The exact answer beside a run: wanted, computed, kept while it fits, and compared with."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from flatland.field import Field
from gui.models.jobs import Job, Runner
from gui.models.levels import coarsened

if TYPE_CHECKING:
    from gui.models.session import Session

_Key = tuple[Any, ...]


class Reference:
    """The exact field of a session's scene at the bands of its method.

    field: None as long as it is not known. wanted: whether another scene's is computed as well.
    computing: whether the runner is at it. The session's `references_changed` tells of all this.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self.field: Field | None = None
        self.wanted = False
        self.runner: Runner | None = None
        self._key: _Key | None = None
        #: What the runner was asked for last; answers to anything else are too late.
        self._asked: Job | None = None
        self._made: dict[str, tuple[_Key, Field, Field | None]] = {}

    @property
    def computing(self) -> bool:
        return self._asked is not None

    def on(self, level: int | None) -> Field | None:
        """The field in the cells of a level."""
        if self.field is None or not level:
            return self.field
        return self._derived(("exact", level), lambda exact: coarsened(exact, level))

    def difference(self, field: Field | None, level: int | None) -> Field | None:
        """A field on a level less the exact one; None where one of them is missing."""
        exact = self.on(level)
        if field is None or exact is None or field.values.shape != exact.values.shape:
            return None
        key = ("difference", id(field))
        return self._derived(
            key, lambda _: Field(field.grid, field.basis, field.values - exact.values), field
        )

    def _derived(
        self, key: _Key, make: Callable[[Field], Field], keep: Field | None = None
    ) -> Field:
        """A field made from others, kept as long as these are on show."""
        assert self.field is not None
        known = self._made.get(key[0])
        if known is None or known[0] != (key, id(self.field)):
            known = (key, id(self.field)), make(self.field), keep
            self._made[key[0]] = known
        return known[1]

    def compute(self) -> None:
        """Compute it, beside the run."""
        self.wanted = True
        asked = None if self._asked is None else _key_of(self._asked)
        if self.runner is None or self._wanted_key() in (self._key, asked):
            return
        self._cancel()
        # Without a stamp: the answer is good for other methods with as many bands as well.
        self._asked = Job("reference", self.session.scene, self.session.choice)
        self.runner.submit(self._asked)
        self.session.references_changed.emit()

    def stop(self) -> None:
        """No exact answer after all."""
        self.wanted = False
        if self._cancel():
            self.session.references_changed.emit()

    def _cancel(self) -> bool:
        """Whether there was something to cancel."""
        if self._asked is None or self.runner is None:
            return False
        self._asked = None
        self.runner.cancel()
        return True

    def take(self, job: Job, exact: Field | None) -> None:
        """The exact field of a job's scene; None if it was cancelled or cannot be had.

        A job that was stopped may have been finished before it heard of it.
        """
        if job is not self._asked:
            return
        self._asked = None
        if exact is not None:
            self.field, self._key = exact, _key_of(job)
            self._measure()
        self.session.references_changed.emit()

    def drop_outdated(self) -> None:
        """Forget what belongs to another scene or to other bands, and stop computing it."""
        wanted = self._wanted_key()
        outdated = self._asked is not None and _key_of(self._asked) != wanted
        if outdated:
            self._cancel()
        if self._key is not None and self._key != wanted:
            self.field, self._key = None, None
            outdated = True
        if outdated:
            self.session.references_changed.emit()

    def renew(self) -> None:
        """For a new run: measure against what is known, or compute what is wanted."""
        if self.field is not None:
            self._measure()
        elif self.wanted:
            self.compute()

    def _measure(self) -> None:
        """Let the run measure its errors."""
        if self.session.choice.steps and self.field is not None:
            self.session.submit("measure", exact=self.field)

    def _wanted_key(self) -> _Key:
        choice = self.session.choice
        return (self.session.scene, choice.bands, choice.bounces)


def _key_of(job: Job) -> _Key:
    return (job.scene, job.choice.bands, job.choice.bounces)
