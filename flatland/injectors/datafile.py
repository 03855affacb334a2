"""Read coefficients from NumPy's file formats, and trust nothing in them."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

import numpy as np
from numpy.lib import format as npy_format
from numpy.typing import NDArray

from flatland.errors import InputError, bad_input
from flatland.grid import Grid
from flatland.memory import require_memory

#: The array's name in an .npz file.
ARRAY_NAME = "coefficients"


def read_coefficients(path: Path, grid: Grid) -> NDArray[np.float64]:
    """The coefficients (size, *grid.shape) in an .npy or .npz file.

    The header is checked before any memory is taken for the array, and pickled objects are
    refused. Raises InputError for a file that is missing, damaged or of the wrong shape.
    """
    if not path.is_file():
        raise _bad_file(path, f"is not a file (looked for {path})")
    try:
        with _array_stream(path) as stream:
            _check_header(stream, path, grid)
        with _array_stream(path) as stream:
            values = npy_format.read_array(stream, allow_pickle=False).astype(np.float64)
    except InputError:
        raise
    except Exception as error:  # a damaged file can make its readers raise anything
        raise _bad_file(path, f"cannot be read as NumPy data ({error})") from error
    if not np.isfinite(values).all():
        raise _bad_file(path, "holds values that are not finite")
    return values


@contextmanager
def _array_stream(path: Path) -> Iterator[IO[bytes]]:
    """The bytes of the one array, in .npy format."""
    if path.suffix == ".npy":
        with path.open("rb") as stream:
            yield stream
        return
    with zipfile.ZipFile(path) as archive:
        if f"{ARRAY_NAME}.npy" not in archive.namelist():
            raise _bad_file(path, f"holds no array named {ARRAY_NAME!r}")
        with archive.open(f"{ARRAY_NAME}.npy") as stream:
            yield stream


def _check_header(stream: IO[bytes], path: Path, grid: Grid) -> None:
    readers = {(1, 0): npy_format.read_array_header_1_0, (2, 0): npy_format.read_array_header_2_0}
    reader = readers.get(npy_format.read_magic(stream))
    if reader is None:
        raise _bad_file(path, "is in a version of the format other than 1.0 and 2.0")
    shape, _, dtype = reader(stream)
    if dtype.kind not in "fiu":
        raise _bad_file(path, f"holds {dtype}, which are not real numbers")
    if shape[1:] != grid.shape or not _is_basis_size(shape[0], grid.dimension):
        size = "2 n - 1" if grid.dimension == 2 else "n²"
        expected = ", ".join(map(str, grid.shape))
        rule = f"holds an array of shape {shape}; it must be ({size}, {expected}) for n bands"
        raise _bad_file(path, rule)
    require_memory((dtype.itemsize + 8) * math.prod(shape), "file", path.name)


def _is_basis_size(size: int, dimension: int) -> bool:
    return size >= 1 and (size % 2 == 1 if dimension == 2 else math.isqrt(size) ** 2 == size)


def _bad_file(path: Path, rule: str) -> InputError:
    return bad_input("file", str(path), rule)
