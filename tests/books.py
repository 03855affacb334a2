"""Runs and their ledgers side by side."""

import numpy as np
import pytest


def assert_same_books(found, expected, entries, within):
    """Two ledgers have the same entries, to some watts."""
    for name in entries:
        assert getattr(found, name) == pytest.approx(getattr(expected, name), abs=within), name


def assert_same_colour(coloured, colour, grey, within):
    """One colour of a run is the run of a grey scene, its books to some watts."""
    found = coloured.accumulated.values[colour]
    np.testing.assert_allclose(found, grey.accumulated.values, rtol=1e-12, atol=1e-14)
    for name in ("left", "absorbed", "reflected", "inside"):
        found = getattr(coloured.ledger, name)[colour]
        assert found == pytest.approx(getattr(grey.ledger, name), abs=within), name
