"""The pixel loop: coefficients of many cells onto one picture of packed 0xffRRGGBB pixels."""

from __future__ import annotations

import numpy as np
from numba import float32, int32, njit

_HALF = np.float32(0.5)
_ZERO, _ONE, _FULL = np.float32(0), np.float32(1), np.float32(256)
#: Share of the colour between the stripes of negative light.
_STRIPE = np.float32(0.45)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def paint_lobes(  # type: ignore[no-untyped-def]
    cells, factors, colours, negative, values, distances, width, opacity, image
):
    """Blend the lobe of every cell over its p x p pixels of `image`.

    cells (nx, ny, size), factors (nx, ny): pixels of radius per intensity; 0 leaves a cell as it
    is. colours (nx, ny) and negative: packed; negative intensity is drawn in stripes. values
    (size, p, p), distances (p, p): a PixelTable. width: of a line [pixels], or 0 to fill.
    image (ny p, nx p), first row on top.

    A pixel is covered by (r - d) / |∇(r - d)| + 1/2: the distance of its middle from the edge. The
    gradient is taken between neighbouring pixels, so that narrow spikes are smooth too.
    """
    nx, ny = factors.shape
    pixels = distances.shape[0]
    signed = np.empty((pixels, pixels), np.float32)
    edge = np.empty((pixels + 2, pixels + 2), np.float32)
    for j in range(ny):
        for i in range(nx):
            factor = factors[i, j]
            if factor == _ZERO:
                continue
            _edges(cells[i, j], factor, values, distances, signed, edge)
            colour = colours[i, j]
            for y in range(pixels):
                target = image[(ny - 1 - j) * pixels + y]
                row, above, below = edge[y + 1], edge[y], edge[y + 2]
                for x in range(pixels):
                    middle = row[x + 1]
                    across = (row[x + 2] - row[x]) * _HALF
                    down = (below[x + 1] - above[x + 1]) * _HALF
                    steep = max(_ONE, across * across + down * down)
                    if middle * abs(middle) < -steep * (_ONE + width) * (_ONE + width):
                        continue
                    place = middle / np.sqrt(steep)
                    line = _HALF * width + _HALF - abs(place)
                    cover = place + _HALF if width == _ZERO else line
                    if cover <= _ZERO:
                        continue
                    cover = min(cover, _ONE) * opacity
                    shown = colour
                    if signed[y, x] < _ZERO:
                        shown = negative
                        if width == _ZERO and (x + y) & 3 > 1:
                            cover *= _STRIPE
                    at = i * pixels + x
                    target[at] = _blend(target[at], shown, cover)


@njit(cache=True, nogil=True, fastmath=True)
def _edges(cell, factor, values, distances, signed, edge):  # type: ignore[no-untyped-def]
    """Signed radius at every pixel, and by how much it reaches beyond it; with a rim of one."""
    pixels = distances.shape[0]
    for y in range(pixels):
        row = signed[y]
        for x in range(pixels):
            row[x] = float32(0)
        for k in range(cell.size):
            coefficient = cell[k] * factor
            table = values[k, y]
            for x in range(pixels):
                row[x] += coefficient * table[x]
        into, away = edge[y + 1], distances[y]
        for x in range(pixels):
            into[x + 1] = abs(row[x]) - away[x]
        into[0] = into[1] + into[1] - into[2]
        into[pixels + 1] = into[pixels] + into[pixels] - into[pixels - 1]
    for x in range(pixels + 2):
        edge[0, x] = edge[1, x] + edge[1, x] - edge[2, x]
        edge[pixels + 1, x] = edge[pixels, x] + edge[pixels, x] - edge[pixels - 1, x]


@njit(cache=True, nogil=True, inline="always")
def _blend(under, colour, cover):  # type: ignore[no-untyped-def]
    """The colour over what is there; red and blue together, green apart."""
    share = int32(cover * _FULL)
    if share >= 256:
        return colour
    both = int32(under & 0xFF00FF)
    both += ((int32(colour & 0xFF00FF) - both) * share) >> 8
    green = int32(under & 0x00FF00)
    green += ((int32(colour & 0x00FF00) - green) * share) >> 8
    return np.uint32(0xFF000000 | (both & 0xFF00FF) | (green & 0x00FF00))


@njit(cache=True, nogil=True, fastmath=True)
def largest_sizes(table, values, largest):  # type: ignore[no-untyped-def]
    """max_d |Σ_k table[d, k] values[k, c]| into largest (cells,); values (size, cells)."""
    count = largest.size
    block = 512
    sums = np.empty(block, np.float32)
    for start in range(0, count, block):
        width = min(block, count - start)
        best = largest[start : start + width]
        for d in range(table.shape[0]):
            for c in range(width):
                sums[c] = float32(0)
            for k in range(table.shape[1]):
                factor = table[d, k]
                row = values[k, start : start + width]
                for c in range(width):
                    sums[c] += factor * row[c]
            for c in range(width):
                best[c] = max(best[c], abs(sums[c]))


@njit(cache=True, nogil=True)
def fill_cells(colours, pixels, image):  # type: ignore[no-untyped-def]
    """Every cell's p x p pixels in its packed colour (nx, ny)."""
    nx, ny = colours.shape
    for j in range(ny):
        for y in range((ny - 1 - j) * pixels, (ny - j) * pixels):
            target = image[y]
            for i in range(nx):
                colour = colours[i, j]
                for x in range(i * pixels, (i + 1) * pixels):
                    target[x] = colour
