"""Passes over long vectors, each doing all that one read of memory allows.

NumPy's own products hand vectors of this length to several BLAS threads, whose waking costs
milliseconds on a busy machine.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

#: Numbers that are worked on at a time, in passes over several vectors.
BLOCK = 2048
FAST = {"reassoc", "contract", "nsz"}


@njit(cache=True, fastmath=FAST)
def dot(a, b):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@njit(cache=True, fastmath=FAST)
def dots(basis, parts, image):  # type: ignore[no-untyped-def]
    """parts[i] += v_i · image, in blocks of the image that stay in the cache."""
    for start in range(0, image.size, BLOCK):
        piece = image[start : start + BLOCK]
        for i in range(parts.size):
            row = basis[i, start : start + BLOCK]
            total = 0.0
            for j in range(piece.size):
                total += row[j] * piece[j]
            parts[i] += total


@njit(cache=True, fastmath=FAST)
def subtract(r, factor, v):  # type: ignore[no-untyped-def]
    """r −= factor v; returns r·r."""
    total = 0.0
    for i in range(r.size):
        value = r[i] - factor * v[i]
        r[i] = value
        total += value * value
    return total


@njit(cache=True, fastmath=FAST)
def two_dots(t, s):  # type: ignore[no-untyped-def]
    product = 0.0
    length = 0.0
    for i in range(t.size):
        product += t[i] * s[i]
        length += t[i] * t[i]
    return product, length


@njit(cache=True, fastmath=FAST)
def add(x, alpha, p, omega, s):  # type: ignore[no-untyped-def]
    for i in range(x.size):
        x[i] += alpha * p[i] + omega * s[i]


@njit(cache=True, fastmath=FAST)
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


@njit(cache=True, fastmath=FAST)
def direction(p, r, beta, omega, v):  # type: ignore[no-untyped-def]
    for i in range(p.size):
        p[i] = r[i] + beta * (p[i] - omega * v[i])


@njit(cache=True, fastmath=FAST)
def squares(v):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(v.size):
        total += v[i] * v[i]
    return total


@njit(cache=True, fastmath=FAST)
def scale(source, factor, target):  # type: ignore[no-untyped-def]
    """target = factor source, from one precision into the other."""
    for i in range(source.size):
        target[i] = factor * source[i]


def norm(vector: NDArray[np.floating]) -> float:
    """The L2 norm, without BLAS."""
    return math.sqrt(np.einsum("i,i", vector, vector))
