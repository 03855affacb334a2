"""Stepping and solving on a CUDA device, through CuPy.

device: finds CuPy and a device, and holds its memory. parts, step_text, local_text, vectors: CUDA
C, written out for one stencil. tables: numbers that it reads. columns: what it reports. sweep: the
callable that the engine uses. state: light that lives on the device. krylov, solving: converged
light.
"""

from flatland.cuda.device import CudaDevice, find_cuda

__all__ = ["CudaDevice", "find_cuda"]
