"""Read triangles from mesh files, and trust nothing in them."""

from __future__ import annotations

import io
import logging
import warnings
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flatland.errors import InputError, bad_input
from flatland.memory import require_memory

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Larger files, and meshes of more triangles, are refused: no grid resolves them.
LARGEST_FILE = 256 * 2**20
MOST_TRIANGLES = 1_000_000
# What trimesh logs about damaged files is said by our errors, and must not reach a terminal.
logging.getLogger("trimesh").addHandler(logging.NullHandler())
#: Bytes of memory that reading takes per byte of the file: up to 16, and what is made of it.
MEMORY_PER_BYTE = 24


def read_triangles(path: Path) -> Array:
    """Corners (T, 3, 3) of all triangles in an .stl, .obj, .ply or .off file, as they stand there.

    Only places are read: no colours, materials or textures, and no other file is opened. Polygons
    of more than three corners are cut into a fan from their first corner, which suits convex ones.
    Raises InputError for a file that is missing, too large, damaged or holds no triangles, and for
    corners that are not there or not finite.
    """
    content = _content(path)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            # All that NumPy says about text that is no number.
            warnings.filterwarnings("error", message="string or file could not be read")
            found = READERS[path.suffix.lower()](content)
            parts = [(np.asarray(points, float), _fans(faces)) for points, faces in found]
    except Exception as error:  # a damaged file can make its readers raise anything
        reason = " ".join(str(error).split())[:100] or type(error).__name__
        raise _bad_file(path, f"cannot be read as {path.suffix} ({reason})") from error
    corners = [_corners(path, *part) for part in parts]
    count = sum(map(len, corners))
    if count > MOST_TRIANGLES:
        raise _bad_file(path, f"holds {count} triangles; at most {MOST_TRIANGLES} can be read")
    triangles = np.concatenate([np.empty((0, 3, 3)), *corners])
    if not count:
        rule = f"holds no triangles: it is empty, cut short, or no {path.suffix} file"
        raise _bad_file(path, rule)
    if not np.isfinite(triangles).all():
        raise _bad_file(path, "holds coordinates that are not finite")
    return triangles


def _content(path: Path) -> bytes:
    """The file's bytes, if it is one and what is made of them fits into memory."""
    if not path.is_file():
        raise _bad_file(path, f"is not a file (looked for {path})")
    try:
        size = path.stat().st_size
        if size > LARGEST_FILE:
            rule = f"is larger than the {LARGEST_FILE >> 20} MiB that a mesh file may have"
            raise _bad_file(path, rule)
        require_memory(MEMORY_PER_BYTE * size, "file", path.name)
        with path.open("rb") as file:
            return file.read(LARGEST_FILE)
    except OSError as error:
        raise _bad_file(path, f"cannot be read ({error.strerror})") from error


def _fans(polygons: Any) -> Indices:
    """Lists of vertices as triangles (T, 3), each polygon cut into a fan."""
    from trimesh.geometry import triangulate_quads

    return np.asarray(triangulate_quads(polygons), np.int64).reshape(-1, 3)


def _corners(path: Path, points: Array, faces: Indices) -> Array:
    """Corners (T, 3, 3) of triangles (T, 3) of vertices (V, 3)."""
    wrong = np.flatnonzero(np.any((faces < 0) | (faces >= len(points)), axis=1))
    if wrong.size:
        rule = f"holds triangles with corners that are not there: {wrong.size} of {len(faces)}"
        raise _bad_file(path, f"{rule}, the first is number {wrong[0] + 1}")
    return np.asarray(points.reshape(-1, 3)[faces])


def _stl(content: bytes) -> Iterable[tuple[Any, Any]]:
    from trimesh.exchange.stl import load_stl

    loaded = load_stl(io.BytesIO(content))
    parts = loaded["geometry"].values() if "geometry" in loaded else [loaded]
    if "face_attributes" not in loaded:  # text
        ends = [content.lower().rfind(word) for word in (b"endloop", b"endsolid")]
        if ends[0] > ends[1]:
            raise ValueError("cut short: no endsolid at its end")
    return [(part["vertices"], part["faces"]) for part in parts]


def _ply(content: bytes) -> Iterable[tuple[Any, Any]]:
    from trimesh.exchange.ply import load_ply

    header, _, body = content.partition(b"end_header")
    if b"format ascii" in header:
        rows = [line.split() for line in header.splitlines()]
        declared = sum(int(row[2]) for row in rows if row[:1] == [b"element"])
        if len(body.splitlines()) <= declared:  # the first line is what is left of end_header
            raise ValueError(f"cut short: it has less than the {declared} lines it declares")
    loaded = load_ply(io.BytesIO(content), fix_texture=False, skip_materials=True)
    return [(loaded["vertices"], loaded["faces"])] if "faces" in loaded else []


def _off(content: bytes) -> Iterable[tuple[Any, Any]]:
    rows = _rows(content)
    if not rows or not rows[0][0].upper().endswith(b"OFF"):
        raise ValueError("it does not begin with OFF")
    rows[0] = rows[0][1:]
    rows = [row for row in rows if row]
    points, polygons = (int(number) for number in rows[0][:2])
    rows = rows[1:]
    if min(points, polygons) < 0 or len(rows) < points + polygons:
        raise ValueError(f"cut short: it has less than {points} vertices and {polygons} faces")
    faces = [[int(number) for number in row] for row in rows[points : points + polygons]]
    return [(_points(rows[:points]), [_polygon(f[1:], f[0]) for f in faces])]


def _obj(content: bytes) -> Iterable[tuple[Any, Any]]:
    """By hand: trimesh takes corner 0 for 1, and loses what is not written its own way."""
    rows = _rows(content.replace(b"\\\r\n", b" ").replace(b"\\\n", b" "))
    points: list[Sequence[bytes]] = []
    faces: list[list[int]] = []
    for row in rows:
        if row[0] == b"v":
            points.append(row[1:])
        elif row[0] == b"f":
            numbers = [int(corner.split(b"/")[0]) for corner in row[1:]]
            # Corners count from 1, or back from the last vertex so far. 0 stays out of range.
            faces.append(_polygon([n - 1 if n >= 0 else len(points) + n for n in numbers]))
    return [(_points(points), faces)]


def _rows(content: bytes) -> list[list[bytes]]:
    """The words of each line that has any, without comments."""
    rows = (line.partition(b"#")[0].split() for line in content.splitlines())
    return [row for row in rows if row]


def _points(rows: Sequence[Sequence[bytes]]) -> Array:
    """The first three numbers of each row, (V, 3)."""
    if any(len(row) < 3 for row in rows):
        raise ValueError("a vertex has less than 3 coordinates")
    return np.array([[float(word) for word in row[:3]] for row in rows]).reshape(-1, 3)


def _polygon(corners: list[int], count: int | None = None) -> list[int]:
    if len(corners[:count]) < max(3, count or 3):
        raise ValueError("a face has less than its corners, or less than 3")
    return corners[:count]


#: ending: from the file's bytes to its parts, each vertices (V, 3) and polygons of their places.
READERS: dict[str, Callable[[bytes], Iterable[tuple[Any, Any]]]] = {
    ".stl": _stl,
    ".obj": _obj,
    ".ply": _ply,
    ".off": _off,
}


def _bad_file(path: Path, rule: str) -> InputError:
    return bad_input("file", str(path), rule)
