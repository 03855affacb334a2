"""Several methods beside the exact answer of one scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from flatland.errors import ConvergenceError, InstabilityError
from flatland.field import Field
from flatland.scene import Scene
from studies.metrics import MEASURES, angular_l2, representation_floor
from studies.reference import Reference
from studies.running import Method, Run, run_method

#: What the columns of a comparison mean.
MEANINGS = {
    **{name: entry.meaning for name, entry in MEASURES.items()},
    "angular": "relative L2 over all directions, truncation to n bands included",
    "floor": "the least `angular` that any field of n bands can have",
}


@dataclass(frozen=True)
class Comparison:
    """Runs, their errors by name, and what did not run with its reason."""

    scene: Scene
    reference: Reference
    runs: list[Run] = field(default_factory=list)
    errors: list[dict[str, float]] = field(default_factory=list)
    failed: list[tuple[Method, str]] = field(default_factory=list)


def measure(result: Field, reference: Reference) -> dict[str, float]:
    """Every error measure of a field, by name; NaN where parallel light leaves none."""
    exact = reference.field(result.basis.bands)
    errors = {name: entry.function(result, exact) for name, entry in MEASURES.items()}
    if not reference.has_density:
        return {**errors, "angular": float("nan"), "floor": float("nan")}
    samples = reference.directions, reference.intensity
    errors["angular"] = angular_l2(result, *samples)
    errors["floor"] = representation_floor(exact, *samples)
    return errors


def compare(
    scene: Scene, methods: Sequence[Method], done: Callable[[int], object] | None = None
) -> Comparison:
    """Run all methods; one that is unstable or does not converge is listed, and stops no other.

    done: called with 1 after each method.
    """
    bounces = all(method.bounces for method in methods)
    comparison = Comparison(scene, Reference(scene, bounces=bounces))
    comparison.reference.field(max(method.bands for method in methods))
    for method in methods:
        try:
            run = run_method(scene, method)
        except (InstabilityError, ConvergenceError) as error:
            comparison.failed.append((method, str(error)))
        else:
            comparison.runs.append(run)
            comparison.errors.append(measure(run.accumulated, comparison.reference))
        if done is not None:
            done(1)
    return comparison


def energy_drift(run: Run) -> float:
    """Flux that the scheme made or lost on the way, as a share of what was emitted."""
    if run.ledger is None:
        return 0.0
    emitted = float(np.sum(run.ledger.emitted))
    return float(np.sum(run.ledger.created)) / emitted if emitted else 0.0
