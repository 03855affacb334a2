"""Converged solutions: (1 − A) S_A = S_0 without stepping there."""

from flatland.solvers.choice import METHODS
from flatland.solvers.converged import SolveReport, solve_converged

__all__ = ["METHODS", "SolveReport", "solve_converged"]
