"""What all tests share: one thread, a seeded generator, strict floating-point arithmetic."""

import os

import hypothesis
import pytest

hypothesis.settings.register_profile("house", deadline=None, derandomize=True, max_examples=25)
hypothesis.settings.load_profile("house")

# Several test processes share the cores; tests of threading ask for threads themselves. NumPy's
# libraries read this when they are loaded, so NumPy is imported below it, in the fixtures.
for name in ("FLATLAND_THREADS", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

SEED = 20100219


@pytest.fixture
def rng():
    """The same random numbers in every run and in every order of tests."""
    import numpy as np

    return np.random.default_rng(SEED)


@pytest.fixture(autouse=True)
def strict_arithmetic():
    """Division by zero, overflow and invalid operations are errors; underflow to zero is not."""
    import numpy as np

    with np.errstate(divide="raise", over="raise", invalid="raise"):
        yield
