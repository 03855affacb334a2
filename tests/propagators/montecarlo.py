"""Light followed photon by photon, with geometry of its own."""

import numpy as np


def first_hits(origins, ways, walls):
    """Distance (K,) to the first of the walls (S, 2, 2), inf if there is none, and its place."""
    reach, hit = np.full(len(origins), np.inf), np.full(len(origins), -1)
    for place, (start, stop) in enumerate(walls):
        extent, offset = stop - start, start - origins
        across = ways[:, 0] * extent[1] - ways[:, 1] * extent[0]
        distance = (offset[:, 0] * extent[1] - offset[:, 1] * extent[0]) / across
        share = (offset[:, 0] * ways[:, 1] - offset[:, 1] * ways[:, 0]) / across
        nearer = (distance > 1e-9) & (share >= 0) & (share <= 1) & (distance < reach)
        reach, hit = np.where(nearer, distance, reach), np.where(nearer, place, hit)
    return reach, hit


def lambertian(extent, rng, count):
    """Unit vectors (count, 2) to the left of an extent (2,) or of extents (count, 2)."""
    extent = np.broadcast_to(extent, (count, 2))
    along = extent / np.hypot(*extent.T)[:, None]
    sine = rng.uniform(-1, 1, (count, 1))
    return sine * along + np.sqrt(1 - sine**2) * np.stack([-along[:, 1], along[:, 0]], axis=-1)


def share_that_leaves(lights, walls, albedo, count, seed):
    """Share of the flux that leaves, and its standard error.

    lights: (start, stop, flux), black; walls: (start, stop), both sides reflect the share albedo.
    """
    rng = np.random.default_rng(seed)
    surfaces = np.array([ends[:2] for ends in lights] + list(walls), float)
    fluxes = np.array([light[2] for light in lights])
    which = rng.choice(len(lights), count, p=fluxes / fluxes.sum())
    extent = surfaces[which, 1] - surfaces[which, 0]
    origins = surfaces[which, 0] + rng.random((count, 1)) * extent
    ways = lambertian(extent, rng, count)
    left = 0
    while len(origins):
        reach, hit = first_hits(origins, ways, surfaces)
        left += np.count_nonzero(hit < 0)
        bright = (hit >= len(lights)) & (rng.random(len(hit)) < albedo)
        origins = origins[bright] + reach[bright, None] * ways[bright]
        extent = surfaces[hit[bright], 1] - surfaces[hit[bright], 0]
        # Back to the side that the light came from.
        came = extent[:, 0] * ways[bright, 1] - extent[:, 1] * ways[bright, 0] < 0
        ways = lambertian(np.where(came[:, None], extent, -extent), rng, len(extent))
    share = left / count
    return share, np.sqrt(share * (1 - share) / count)
