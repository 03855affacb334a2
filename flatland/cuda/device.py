"""A CUDA device, as CuPy reaches it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from flatland.cuda.vectors import VECTOR_KERNELS, Vectors, vector_text
from flatland.errors import InputError, bad_input
from flatland.memory import gigabytes

if TYPE_CHECKING:
    from flatland.cuda.state import CudaState
    from flatland.kernels import Layout
    from flatland.kernels.any_sweep import AnySweep
    from flatland.kernels.reports import Buffer
    from flatland.solvers import SolveReport
    from flatland.stencil import Stencil

#: An array in the device's memory, or a kernel: CuPy has no types that could be checked.
DeviceArray = Any
Kernel = Callable[..., None]


class CudaDevice:
    """A device's memory and programs, and what a level makes of them; see `flatland.devices`.

    Arrays go to kernels as CuPy's own, numbers as NumPy scalars of the type that the kernel
    declares: CuPy checks neither. Uses of CuPy are few, and all here but for calls of kernels:
    `zeros`, `ndarray.set`, `ndarray.get` and `ndarray.fill`, `RawModule`, the device's number and
    properties.
    """

    def __init__(self, cupy: Any) -> None:
        self._cupy = cupy
        runtime = cupy.cuda.runtime
        if runtime.getDeviceCount() < 1:
            raise RuntimeError("there is no CUDA device")
        name = runtime.getDeviceProperties(runtime.getDevice())["name"]
        #: What its maker calls it.
        self.name = name.decode() if isinstance(name, bytes) else str(name)
        # Compiles: whether there is a compiler had better be known now.
        _ = self.vectors

    @cached_property
    def vectors(self) -> Vectors:
        """Passes over long vectors."""
        return Vectors(self, self.program(vector_text(), VECTOR_KERNELS))

    def zeros(self, size: int, dtype: Any) -> DeviceArray:
        """A field or table (size,) of zeros. Raises InputError where there is no room for it."""
        try:
            return self._cupy.zeros((max(size, 1),), dtype)
        except self._cupy.cuda.memory.OutOfMemoryError:
            needed = gigabytes(size * np.dtype(dtype).itemsize)
            rule = f"has no room for another field of {needed}"
            raise bad_input("device", "cuda", rule, ("cpu",)) from None

    def upload(self, values: NDArray[Any]) -> DeviceArray:
        """A copy (size,) of all numbers of an array, on the device."""
        flat = np.ascontiguousarray(values).reshape(-1)
        array = self.zeros(flat.size, flat.dtype)
        if flat.size:
            array.set(flat)
        return array

    def program(self, text: str, names: Iterable[str]) -> dict[str, Kernel]:
        """Compiles CUDA C, and gives its kernels."""
        module = self._cupy.RawModule(code=text)
        return {name: module.get_function(name) for name in names}

    # -- what a level needs ---------------------------------------------------------------------

    def state(self, layout: Layout, scale: float, skip: bool, drop: float) -> CudaState:
        from flatland.cuda.state import CudaState

        return CudaState(layout, scale, skip, drop, self)

    def sweep(
        self,
        stencil: Stencil,
        layout: Layout,
        transmittance: NDArray[np.float64] | None,
        sums: tuple[int, ...],
    ) -> AnySweep:
        from flatland.cuda.sweep import CudaSweep

        return CudaSweep(self, stencil, layout, transmittance, sums).prepared()

    def solve(
        self, sweep: AnySweep, right: Buffer, answer: Buffer, tolerance: float, method: str
    ) -> SolveReport:
        from flatland.cuda.solving import solve_on_device

        return solve_on_device(sweep, right, answer, tolerance, method)


def find_cuda() -> CudaDevice:
    """The device that CuPy has chosen. Raises InputError with the reason if there is none."""
    try:
        import cupy

        return CudaDevice(cupy)
    except ImportError as error:
        reason = f"CuPy cannot be imported ({_first_line(error)})"
    except (RuntimeError, OSError) as error:
        reason = _first_line(error)
    raise _refusal(reason)


def _refusal(reason: str) -> InputError:
    return bad_input("device", "cuda", f"needs CuPy and a CUDA device: {reason}", ("cpu",))


def _first_line(error: Exception) -> str:
    """An error in one line, without the rulers that CuPy puts round some."""
    lines = [line.strip(" =") for line in str(error).splitlines()]
    return next((line for line in lines if line), type(error).__name__)
