"""Ledgers of schemes that answer a scene at once, entry by entry and colour by colour."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from flatland.ledger import Ledger


def weighted_sum(ledgers: Sequence[Ledger], weights: Sequence[float]) -> Ledger:
    """Each entry as the weighted sum of the same entry of all, () or (C,) alike."""
    return _entrywise(lambda name: sum(w * getattr(x, name) for x, w in zip(ledgers, weights)))


def by_colour(ledger: Ledger, coloured: bool) -> Ledger:
    """Entries (C,) as they are, or for a grey scene ()."""
    return ledger if coloured else _entrywise(lambda name: np.sum(getattr(ledger, name)))


def _entrywise(entry: Callable[[str], Any]) -> Ledger:
    return Ledger(**{item.name: np.asarray(entry(item.name), float) for item in fields(Ledger)})
