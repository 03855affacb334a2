"""How the kernels of this package are compiled."""

from __future__ import annotations

from numba import njit

#: For functions that only other kernels call: the wrappers for Python would cost a fifth of the
#: compile time. The cache is keyed by each function's own file: after editing a callee in another
#: file, clear propagators/analytic/__pycache__.
inner = njit(cache=True, error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)
