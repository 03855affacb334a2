"""What walls receive of a lamp, and what becomes of it, in 2D and 3D."""

import numpy as np

from flatland.shadow_map import light_budget


def received(shadow_map, walls):
    """What each wall receives of a light of unit strength."""
    return np.bincount(shadow_map.walls, shadow_map.received, len(walls))


def assert_books_of_colours(found, walls, strength):
    """Walls reflect what they receive of a light of strength (C,) as their albedo says."""
    budget = light_budget(found, walls, strength)
    per_wall = received(found, walls)[:, None] * strength
    table = np.array([np.broadcast_to(wall.albedo, len(strength)) for wall in walls])
    np.testing.assert_allclose(budget.received, per_wall.sum(axis=0), rtol=1e-12)
    np.testing.assert_allclose(budget.absorbed, (per_wall * (1 - table)).sum(axis=0), rtol=1e-12)
    np.testing.assert_allclose(budget.reflected, (per_wall * table).sum(axis=0), rtol=1e-12)
    np.testing.assert_allclose(budget.emitted, budget.received + budget.escaped, rtol=1e-12)
    np.testing.assert_allclose(budget.emitted, found.emitted * strength)
