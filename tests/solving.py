"""Converged fields of made-up light, by the solver and by a sparse matrix made in another way."""

import numpy as np
from scipy.sparse import eye_array
from scipy.sparse.linalg import spsolve
from stepping import Stepper, operator

from flatland.solvers import solve_converged


def solved(stencil, shape, light, transmittance, method, tolerance=1e-9):
    """The field (size, *shape), and the report."""
    stepper = Stepper(stencil, shape, transmittance)
    right, answer = stepper.buffer(light), stepper.buffer()
    report = solve_converged(stepper.sweep, right, answer, tolerance, method)
    return stepper.layout.view(answer).copy(), report


def direct_answer(stencil, light, transmittance):
    """The same by a factorisation."""
    matrix = eye_array(light.size) - operator(stencil, light.shape[1:], transmittance)
    return np.asarray(spsolve(matrix.tocsc(), light.ravel())).reshape(light.shape)
