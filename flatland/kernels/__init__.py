"""The sweep: the one loop where the time goes.

layout: where a coefficient lies in memory. recipe: what a sweep is to do. orbits: neighbours that
are each other's mirror images, taken together. writer, arrivals, storing, frame, assembly: the
sweep of one stencil, written out as LLVM assembly. compiler: assembly to machine code. programs:
those of one sweep. threads: rows shared among cores. reflection: what walls send back. mirroring:
images behind half a grid. sweep: the callable that the engine uses.
"""

from flatland.first_time import listen
from flatland.kernels.layout import Layout
from flatland.kernels.reflection import Reflection
from flatland.kernels.sweep import Sweep

listen()

__all__ = ["Layout", "Reflection", "Sweep"]
