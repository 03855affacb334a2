"""Scenes whose errors an independent code recorded (relative L2 of all coefficients)."""

import numpy as np
from analytic_scenes import make_scene

import propagators


def one_light(scale=1):
    """Scene 1: one light on a grid line, 32 x 32 cells times `scale`."""
    ends = [(6 * scale, scale), (11 * scale, scale)]
    return make_scene((32 * scale, 32 * scale), [(*ends, 5)], ())


def clutter():
    """Scene 3: two lights among 200 short walls."""
    rng = np.random.default_rng(7)
    middles, angles = rng.uniform(2, 62, (200, 2)), rng.uniform(0, np.pi, 200)
    halves = rng.uniform(0.5, 2, (200, 1)) / 2 * np.stack([np.cos(angles), np.sin(angles)], -1)
    lights = [((8.3, 4.1), (24.7, 6.2), 3), ((58.2, 52.1), (57.5, 38.4), 2)]
    return make_scene((64, 64), lights, list(zip(middles - halves, middles + halves)))


def exact(scene, bands):
    return propagators.create("analytic").solve(scene, bands).values


def error(values, reference):
    return float(np.linalg.norm(values - reference) / np.linalg.norm(reference))
