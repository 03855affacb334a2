"""Pieces of CUDA C that all kernels are made of.

The text is plain C but for the words that the preamble defines where nobody has: threads go over
the numbers of their block with a stride, so that one thread alone, as a C compiler for the host
makes it, does the same as many.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from flatland.kernels.layout import Layout

#: Threads of a block, at most, and blocks: enough to fill a device, few enough to add their sums up
#: in one go.
LARGEST_BLOCK = 256
BLOCKS = 2048
#: Numbers that the threads of a block share; 48 KiB is what every device has.
_SHARED = 6144
#: Positions of a field above which they need 64 bits.
_LARGEST_PLACE = 2**31 - 1

_PREAMBLE = """\
#ifndef KERNEL
#define KERNEL extern "C" __global__
#define DEVICE static __device__
#endif
typedef {real} real;
typedef {place} place;
#define FUSED {fused}
#define LARGER {larger}
"""


def preamble(dtype: np.dtype, size: int) -> str:
    """Types and words for fields of one precision with `size` numbers."""
    single = dtype == np.float32
    return _PREAMBLE.format(
        real=real_of(dtype),
        place="int" if size <= _LARGEST_PLACE else "long long",
        fused="fmaf" if single else "fma",
        larger="fmaxf" if single else "fmax",
    )


def real_of(dtype: np.dtype) -> str:
    return "float" if dtype == np.float32 else "double"


def number(value: float, dtype: np.dtype) -> str:
    """A constant that a compiler reads back bit for bit."""
    return repr(float(dtype.type(value))) + ("f" if dtype == np.float32 else "")


def block_for(sums: int) -> int:
    """Threads of a block that adds up so many sums: all that share memory, in a power of two."""
    block = LARGEST_BLOCK
    while block * sums > _SHARED and block > 1:
        block //= 2
    return block


def blocks_for(work: int, block: int) -> int:
    """Blocks for so many cells or numbers; each thread takes several where there are more."""
    return max(1, min(BLOCKS, -(-work // block)))


def each(variable: str, count: str, block: int, body: Iterable[str]) -> list[str]:
    """A loop of this thread, `t`, over its share of `count` numbers."""
    return [
        f"for (long long {variable} = (long long)blockIdx.x * {block} + t; {variable} < {count};",
        f"     {variable} += (long long)gridDim.x * {block}) {{",
        *indented(body),
        "}",
    ]


def threads(block: int, body: Iterable[str]) -> list[str]:
    """What each thread of a block does before it waits for all others."""
    return [
        f"for (int t = threadIdx.x; t < {block}; t += blockDim.x) {{",
        *indented(body),
        "}",
        "__syncthreads();",
    ]


def kernel(name: str, arguments: Sequence[str], body: Iterable[str]) -> list[str]:
    """A function that is started from outside."""
    listed = ", ".join(arguments)
    return [f"KERNEL void {name}({listed})", "{", *indented(body), "}", ""]


def summing(sums: Sequence[str], block: int, body: Iterable[str]) -> list[str]:
    """Threads that each add up some sums, and the block's in `partial[row + …]`.

    sums: names of variables that `body` adds to; BLOCKS numbers apart in `partial`, one a block.
    """
    zeros = [f"double {name} = 0.0;" for name in sums]
    keep = [f"shared[{w * block} + t] = {name};" for w, name in enumerate(sums)]
    return [
        f"__shared__ double shared[{len(sums) * block}];",
        *threads(block, [*zeros, *body, *keep]),
        *halving(len(sums), block),
        f"for (int w = threadIdx.x; w < {len(sums)}; w += blockDim.x)",
        f"    partial[(row + w) * {BLOCKS} + blockIdx.x] = shared[w * {block}];",
    ]


def halving(sums: int, block: int) -> list[str]:
    """Sums of `shared`, `block` numbers each, in their first numbers."""
    return [
        f"for (int half = {block // 2}; half > 0; half /= 2) {{",
        "    for (int t = threadIdx.x; t < half; t += blockDim.x)",
        f"        for (int w = 0; w < {sums}; ++w)",
        f"            shared[w * {block} + t] += shared[w * {block} + t + half];",
        "    __syncthreads();",
        "}",
    ]


def gather() -> list[str]:
    """Kernel that adds up what all blocks have left in `partial`, a block a sum."""
    block = LARGEST_BLOCK
    own = [
        "double own = 0.0;",
        f"for (int b = t; b < {BLOCKS}; b += {block})",
        f"    own += partial[(long long)blockIdx.x * {BLOCKS} + b];",
        "shared[t] = own;",
    ]
    body = [
        f"__shared__ double shared[{block}];",
        *threads(block, own),
        *halving(1, block),
        "if (threadIdx.x == 0)",
        "    sums[blockIdx.x] = shared[0];",
    ]
    return kernel(
        "gather", ["const double* __restrict__ partial", "double* __restrict__ sums"], body
    )


def box_arguments(dimension: int) -> list[str]:
    """First cell and number of cells along each axis."""
    names = [f"{name}_{axis}" for axis in range(dimension) for name in ("first", "count")]
    return [f"long long {name}" for name in names]


def box_size(dimension: int) -> str:
    """Declares `cells`, how many a box has."""
    product = " * ".join(f"count_{axis}" for axis in range(dimension))
    return f"const long long cells = {product};"


def position(layout: Layout) -> list[str]:
    """Declares `at`, where cell number q of a box lies in a field.

    Threads next to each other take cells next to each other in memory.
    """
    last = len(layout.shape) - 1
    lines = ["place rest = (place)q;"]
    for axis in range(last, 0, -1):
        lines.append(f"const place x_{axis} = (place)first_{axis} + rest % (place)count_{axis};")
        lines.append(f"rest /= (place)count_{axis};")
    lines.append("const place x_0 = (place)first_0 + rest;")
    terms = [f"x_{axis} * {stride}" for axis, stride in enumerate(layout.strides)]
    return [*lines, f"const place at = {layout.front} + {' + '.join(terms)};"]


def cell_number(layout: Layout) -> str:
    """Declares `cell`, the number of the cell at `position` in its grid."""
    cell = "x_0"
    for axis, count in enumerate(layout.shape[1:], 1):
        cell = f"({cell}) * {count} + x_{axis}"
    return f"const place cell = {cell};"


def indented(lines: Iterable[str]) -> list[str]:
    return [f"    {line}" if line else line for line in lines]
