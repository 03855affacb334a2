"""A stand-in for the few parts of CuPy that are used, for machines without a device.

Arrays are NumPy's, kept out of reach; kernels are compiled for the host by a C compiler. One thread
does the work of a block, or, to find what goes wrong between threads, as many as a device would
start. What CuPy leaves unchecked is checked here: types of arguments, host arrays that go to a
kernel, and, by what surrounds each array, that nothing is read or written beside it.
"""

import ctypes
import hashlib
import re
import shutil
import subprocess
import tempfile
import threading
import types
from pathlib import Path

import numpy as np

COMPILER = next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))), None)
#: Numbers on either side of an array; reading them gives NaN.
_MARGIN = 4096

_HEAD = """\
#include <math.h>
#include <sched.h>
#define KERNEL
#define DEVICE static
#define __syncthreads wait_for_all
typedef struct { unsigned x, y, z; } Place;
static __thread Place threadIdx;
static Place blockIdx, blockDim, gridDim;
static unsigned arrived, turn;
static void wait_for_all(void) {
    unsigned now = __atomic_load_n(&turn, __ATOMIC_SEQ_CST);
    if (__atomic_add_fetch(&arrived, 1, __ATOMIC_SEQ_CST) == blockDim.x) {
        __atomic_store_n(&arrived, 0, __ATOMIC_SEQ_CST);
        __atomic_add_fetch(&turn, 1, __ATOMIC_SEQ_CST);
    }
    while (__atomic_load_n(&turn, __ATOMIC_SEQ_CST) == now) sched_yield();
}
void enter_thread(unsigned number) { threadIdx.x = number; }
/* What threads of a block share: no number before one of them writes it. */
static double of_block[6144];
void enter_block(unsigned number) {
    blockIdx.x = number;
    for (int i = 0; i < 6144; ++i) of_block[i] = NAN;
}
void enter_grid(unsigned blocks, unsigned each) {
    gridDim.x = blocks;
    blockDim.x = each;
}
"""

_SHARED = r"__shared__ double shared\[(\d+)\];"

_TYPES = {
    "float": (np.float32, ctypes.c_float),
    "double": (np.float64, ctypes.c_double),
    "int": (np.int32, ctypes.c_int),
    "long long": (np.int64, ctypes.c_longlong),
}


class OutOfMemoryError(MemoryError):
    """As CuPy's."""


class CUDARuntimeError(RuntimeError):
    """As CuPy's."""


class Array:
    """As cupy.ndarray, in one dimension, for what the engine does with it."""

    def __init__(self, size, dtype):
        self.dtype, self.size, self.shape = np.dtype(dtype), size, (size,)
        guard = np.nan if self.dtype.kind == "f" else np.iinfo(self.dtype).min
        self._guard = np.full(_MARGIN, guard, self.dtype)
        self._all = np.concatenate([self._guard, np.zeros(size, self.dtype), self._guard])
        self._values = self._all[_MARGIN : _MARGIN + size]

    def set(self, values):
        if type(values) is not np.ndarray:
            raise TypeError("only numpy.ndarray can be set")
        if (values.dtype, values.shape) != (self.dtype, self.shape):
            raise ValueError(f"{values.dtype} {values.shape} for {self.dtype} {self.shape}")
        self._values[:] = values

    def get(self, out=None):
        self.require_untouched_margins()
        if out is None:
            return self._values.copy()
        if (out.dtype, out.shape) != (self.dtype, self.shape) or not out.flags.c_contiguous:
            raise ValueError(f"{out.dtype} {out.shape} for {self.dtype} {self.shape}")
        out[:] = self._values
        return out

    def fill(self, value):
        self._values[:] = value

    def require_untouched_margins(self):
        for margin in (self._all[:_MARGIN], self._all[_MARGIN + self.size :]):
            np.testing.assert_array_equal(margin, self._guard)

    @property
    def address(self):
        return self._values.ctypes.data


class Kernel:
    """As cupy.RawKernel: kernel(grid, block, arguments)."""

    def __init__(self, library, name, parameters, cupy):
        self._library, self._name, self._cupy = library, name, cupy
        self._function = getattr(library, name)
        self._function.restype = None
        self._parameters = parameters

    def __call__(self, grid, block, arguments):
        for size in (grid, block, arguments):
            assert type(size) is tuple
        (blocks,), (width,) = grid, block
        assert type(blocks) is int
        assert type(width) is int
        assert 1 <= blocks < 2**31
        assert 1 <= width <= 1024
        values = self._checked(arguments)
        self._cupy.launched.append(self._name)
        width = width if self._cupy.threaded else 1
        self._library.enter_grid(blocks, width)
        for number in range(blocks):
            self._library.enter_block(number)
            self._run(width, values)
        for argument in arguments:
            if type(argument) is Array:
                argument.require_untouched_margins()

    def _run(self, width, values):
        def thread(number):
            self._library.enter_thread(number)
            self._function(*values)

        if width == 1:
            thread(0)
            return
        started = [threading.Thread(target=thread, args=(number,)) for number in range(width)]
        for each in started:
            each.start()
        for each in started:
            each.join()

    def _checked(self, arguments):
        """As C takes them. Raises TypeError for what a device would misread."""
        if len(arguments) != len(self._parameters):
            raise TypeError(f"{self._name}: {len(arguments)} of {len(self._parameters)} arguments")
        values, written, read = [], [], []
        for argument, (kind, pointer, constant) in zip(arguments, self._parameters):
            number, c_type = _TYPES[kind]
            if pointer and type(argument) is Array and argument.dtype == number:
                (read if constant else written).append(argument.address)
                values.append(ctypes.c_void_p(argument.address))
            elif not pointer and type(argument) is number:
                values.append(c_type(argument))
            else:
                raise TypeError(f"{self._name}: {type(argument)} for {kind}{'*' * pointer}")
        assert len(set(written)) == len(written)
        assert not set(written) & set(read)
        return values


class HostCupy(types.SimpleNamespace):
    """What stands for the module `cupy`.

    threaded: blocks of as many threads as they are started with. launched: names of kernels.
    """

    def __init__(self, threaded=False, devices=1):
        properties = {"name": b"stand-in"}
        runtime = types.SimpleNamespace(
            getDeviceCount=lambda: devices,
            getDevice=lambda: 0,
            getDeviceProperties=lambda number: properties,
            CUDARuntimeError=CUDARuntimeError,
        )
        memory = types.SimpleNamespace(OutOfMemoryError=OutOfMemoryError)
        super().__init__(
            threaded=threaded,
            launched=[],
            cuda=types.SimpleNamespace(runtime=runtime, memory=memory),
            RawModule=lambda *, code: RawModule(code, self),
        )

    def zeros(self, shape, dtype):
        (size,) = shape
        return Array(size, dtype)


class RawModule:
    """As cupy.RawModule(code=…)."""

    def __init__(self, code, cupy):
        self._library, self._cupy = compiled(code), cupy
        self._signatures = dict(signatures(code))

    def get_function(self, name):
        return Kernel(self._library, name, self._signatures[name], self._cupy)


def signatures(code):
    """Kernels of a text, with (type, whether a pointer, whether constant) of each parameter."""
    real = re.search(r"typedef (float|double) real;", code).group(1)
    pattern = r"^(?:const )?([a-z ]+?)(\*?)(?: __restrict__)? \w+$"
    for name, listed in re.findall(r"^KERNEL void (\w+)\((.*)\)$", code, re.MULTILINE):
        parameters = []
        for text in listed.split(", "):
            kind, pointer = re.match(pattern, text).groups()
            kind = real if kind == "real" else kind
            parameters.append((kind, bool(pointer), text.startswith("const ")))
        yield name, parameters


_libraries = {}


def compiled(code):
    """The text as a library of this machine; kept, so that no text is compiled twice."""
    key = hashlib.sha256(code.encode()).hexdigest()
    if key not in _libraries:
        with tempfile.TemporaryDirectory() as folder:
            source, library = Path(folder, "text.c"), Path(folder, "text.so")
            assert all(int(size) <= 6144 for size in re.findall(_SHARED, code))
            source.write_text(_HEAD + re.sub(_SHARED, "double* shared = of_block;", code))
            strict = ["-std=gnu11", "-Wall", "-Werror", "-Wno-unknown-pragmas"]
            quick = ["-O1", "-ffp-contract=off", "-fPIC", "-shared"]
            spared = ["-Wno-unused-function", "-Wno-unused-variable"]
            options = [*strict, *spared, *quick, "-o", str(library), str(source), "-lm"]
            process = subprocess.run([COMPILER, *options], capture_output=True, text=True)
            if process.returncode:
                raise RuntimeError(process.stderr)
            _libraries[key] = ctypes.CDLL(str(library))
    return _libraries[key]
