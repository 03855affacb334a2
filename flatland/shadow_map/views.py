"""How a light sees walls: keys across its rays, and nearness along them.

A ray is a pair (u, v): (cos θ, sin θ) round a point light, (1, p) for parallel light, where p runs
across it. In both, what the light sees of a point is a pair too, and a wall's nearness is linear
in (u, v): 1/r of a straight wall is a sinusoid of θ, and minus the way to it is linear in p. So two
walls are compared, and their crossing is found, by the same arithmetic for both kinds of light.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Sine of the angle under which a wall counts as seen from its end: it covers nothing then.
EDGE_ON = 1e-13


@dataclass(frozen=True, eq=False)
class View:
    """R walls as one light sees them; lengths in cells.

    ends: (R, 2, 2), turned so that light arrives on the left of start -> stop. walls: (R,) place
    of each in the scene. seen: (R, 2, 2), pairs of both ends. nearness: (R, 2), its product with
    a ray is greater the nearer the wall, and positive. spans: (R, 2), first and last key. borders:
    (texels + 1,) keys at which texels begin and end. angular: whether keys are angles.
    """

    ends: Array
    walls: Indices
    seen: Array
    nearness: Array
    spans: Array
    borders: Array
    angular: bool

    def rays(self, keys: Array) -> Array:
        """Rays (K, 2) of keys (K,)."""
        if self.angular:
            return np.stack([np.cos(keys), np.sin(keys)], axis=-1)
        return np.stack([np.ones_like(keys), keys], axis=-1)

    def keys(self, rays: Array) -> Array:
        """Keys (K,) of pairs (K, 2) along rays."""
        return np.arctan2(rays[..., 1], rays[..., 0]) if self.angular else rays[..., 1]


def point_view(ends: Array, walls: Indices, position: Array, texels: int) -> View:
    """Walls (S, 2, 2) around a point light (2,): keys are angles from -π to π."""
    seen = ends - position
    cross = seen[:, 0, 0] * seen[:, 1, 1] - seen[:, 0, 1] * seen[:, 1, 0]
    size = np.hypot(*seen[:, 0].T) * np.hypot(*seen[:, 1].T)
    kept = np.abs(cross) > EDGE_ON * size
    ends, seen = _turned(ends[kept], cross[kept] < 0), _turned(seen[kept], cross[kept] < 0)
    along = ends[:, 1] - ends[:, 0]
    # The wall's line is n·x = d; 1/r = n·ω/d, with n d of length |cross|.
    nearness = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.abs(cross[kept])[:, None]
    borders = np.linspace(-np.pi, np.pi, texels + 1)
    spans = np.arctan2(seen[..., 1], seen[..., 0])
    view = View(ends, walls[kept], seen, nearness, spans, borders, angular=True)
    return _unwrapped(view)


def parallel_view(
    ends: Array, walls: Indices, direction: Array, shape: tuple[int, ...], texels: int
) -> View:
    """Walls (S, 2, 2) in light along a unit vector (2,): keys run across the grid."""
    across = np.array([-direction[1], direction[0]])
    corners = np.array([[0, 0], [shape[0], 0], [0, shape[1]], shape], float)
    keys = ends @ across
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    kept = np.abs(keys[:, 1] - keys[:, 0]) > EDGE_ON * length
    turned = keys[kept, 1] < keys[kept, 0]
    ends, spans = _turned(ends[kept], turned), _turned(keys[kept], turned)
    way = ends @ direction
    slope = (way[:, 1] - way[:, 0]) / (spans[:, 1] - spans[:, 0])
    # Any way further than all that is in the grid makes nearness positive.
    furthest = 1.0 + 2.0 * np.abs(corners).sum(axis=1).max()
    nearness = np.stack([furthest - way[:, 0] + slope * spans[:, 0], -slope], axis=1)
    seen = np.stack([np.ones_like(spans), spans], axis=-1)
    low, high = (corners @ across).min(), (corners @ across).max()
    borders = np.linspace(low, high, texels + 1)
    return View(ends, walls[kept], seen, nearness, np.clip(spans, low, high), borders, False)


def _turned(pairs: Array, turned: NDArray[np.bool_]) -> Array:
    """Pairs (R, 2, ...), both entries swapped where turned (R,)."""
    result = pairs.copy()
    result[turned] = result[turned][:, ::-1]
    return result


def _unwrapped(view: View) -> View:
    """A wall across the angle π as two: up to π, and on from -π."""
    wraps = view.spans[:, 1] < view.spans[:, 0]
    row = np.concatenate([np.arange(len(wraps)), np.flatnonzero(wraps)])
    spans = view.spans[row]
    spans[: len(wraps)][wraps, 1] = np.pi
    spans[len(wraps) :, 0] = -np.pi
    ends, walls, seen = view.ends[row], view.walls[row], view.seen[row]
    return View(ends, walls, seen, view.nearness[row], spans, view.borders, view.angular)
