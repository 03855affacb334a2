"""The size of the last cache, where systems tell it and where they do not."""

import os

import pytest

from flatland.kernels.cache import last_cache_bytes


@pytest.fixture(autouse=True)
def asked_anew():
    last_cache_bytes.cache_clear()
    yield
    last_cache_bytes.cache_clear()


def test_what_the_system_tells(monkeypatch):
    monkeypatch.setattr(os, "sysconf", lambda name: 2**24, raising=False)
    assert last_cache_bytes() == 2**24


def unknown(name):
    raise ValueError(name)


@pytest.mark.parametrize("answer", [lambda name: 0, lambda name: -1, unknown])
def test_a_guess_where_it_does_not(answer, monkeypatch):
    monkeypatch.setattr(os, "sysconf", answer, raising=False)
    assert last_cache_bytes() == 32 * 2**20
