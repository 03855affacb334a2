"""Passes over long vectors, each doing all that one read of memory allows.

NumPy's own products hand vectors of this length to several BLAS threads, whose waking costs
milliseconds on a busy machine.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

_FAST = {"reassoc", "contract", "nsz"}


@njit(cache=True, fastmath=_FAST)
def dot(a, b):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@njit(cache=True, fastmath=_FAST)
def subtract(r, factor, v):  # type: ignore[no-untyped-def]
    """r −= factor v; returns r·r."""
    total = 0.0
    for i in range(r.size):
        value = r[i] - factor * v[i]
        r[i] = value
        total += value * value
    return total


@njit(cache=True, fastmath=_FAST)
def two_dots(t, s):  # type: ignore[no-untyped-def]
    product = 0.0
    length = 0.0
    for i in range(t.size):
        product += t[i] * s[i]
        length += t[i] * t[i]
    return product, length


@njit(cache=True, fastmath=_FAST)
def add(x, alpha, p, omega, s):  # type: ignore[no-untyped-def]
    for i in range(x.size):
        x[i] += alpha * p[i] + omega * s[i]


@njit(cache=True, fastmath=_FAST)
def subtract_and_dot(r, omega, t, shadow):  # type: ignore[no-untyped-def]
    """r −= omega t; returns r·r and shadow·r."""
    squares = 0.0
    product = 0.0
    for i in range(r.size):
        value = r[i] - omega * t[i]
        r[i] = value
        squares += value * value
        product += shadow[i] * value
    return squares, product


@njit(cache=True, fastmath=_FAST)
def direction(p, r, beta, omega, v):  # type: ignore[no-untyped-def]
    for i in range(p.size):
        p[i] = r[i] + beta * (p[i] - omega * v[i])


@njit(cache=True, fastmath=_FAST)
def squares(v):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(v.size):
        total += v[i] * v[i]
    return total


@njit(cache=True, fastmath=_FAST)
def scale(source, factor, target):  # type: ignore[no-untyped-def]
    """target = factor source, from one precision into the other."""
    for i in range(source.size):
        target[i] = factor * source[i]


def norm(vector: NDArray[np.floating]) -> float:
    """The L2 norm, without BLAS."""
    return math.sqrt(np.einsum("i,i", vector, vector))
