"""Results as labelled files: netCDF, written whole or not at all."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flatland.errors import ResultFileError
from flatland.field import Field
from flatland.scene import Scene, scene_to_toml

_AXES = ("x", "y", "z")


def versions() -> dict[str, str]:
    """Versions of this project and of what its numbers depend on."""
    names = {
        "flatland": "flatland-light",
        "numpy": "numpy",
        "scipy": "scipy",
        "llvmlite": "llvmlite",
    }
    return {key: _version(name) for key, name in names.items()}


def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return "unknown"


def field_data(field: Field, name: str = "accumulated", suffix: str = "") -> xr.DataArray:
    """A field with named axes: [colour,] coefficient, x, y[, z]; cells by their centres [m].

    suffix: after the names of the axes, for a grid beside another one.
    """
    grid = field.grid
    axes = tuple(axis + suffix for axis in _AXES[: grid.dimension])
    centres = {
        axis: grid.origin[i] + (np.arange(grid.shape[i]) + 0.5) * grid.spacing
        for i, axis in enumerate(axes)
    }
    dims = ("colour",) * field.coloured + ("coefficient", *axes)
    coords: dict[str, Any] = {"band": ("coefficient", field.basis.degrees), **centres}
    unit = "W/rad" if grid.dimension == 2 else "W/sr"
    array = xr.DataArray(field.values, coords, dims, name, {"units": unit})
    for axis in axes:
        array[axis].attrs["units"] = "m"
    return array


def result_dataset(
    scene: Scene,
    fields: Mapping[str, Field],
    method: Mapping[str, Any],
    levels: Sequence[Field] = (),
    index: NDArray[np.integer] | None = None,
) -> xr.Dataset:
    """Fields of one scene with all that is needed to compute them again.

    method: what was done, as plain values; stored as JSON beside the scene's TOML text. levels:
    fields of an octree, stored as `level_0`, `level_1`, … on axes `x`, `x_1`, …. index: the level
    that each cell was read from, (*shape).
    """
    data = xr.Dataset({name: field_data(field, name) for name, field in fields.items()})
    for number, field in enumerate(levels):
        name = f"level_{number}"
        data[name] = field_data(field, name, f"_{number}" if number else "")
    if index is not None:
        data["index"] = (_AXES[: index.ndim], index, {"meaning": "level that a cell is read from"})
    data.attrs = {
        "title": scene.title,
        "scene": scene_to_toml(scene),
        "method": json.dumps(method, sort_keys=True, default=_plain),
        "versions": json.dumps(versions(), sort_keys=True),
        "conventions": "intensity that leaves each cell, coefficients of an orthonormal basis",
    }
    return data


def save_dataset(data: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write a netCDF file; an interrupted or failed write leaves what was there before.

    Raises ResultFileError naming the file and the reason.
    """
    return write_atomically(path, lambda place: data.to_netcdf(place, engine="h5netcdf"))


def load_dataset(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a file that `save_dataset` wrote. Raises ResultFileError."""
    try:
        return xr.load_dataset(Path(path), engine="h5netcdf")
    except (OSError, ValueError, KeyError) as error:
        message = f"{os.fspath(path)}: is not a readable result file: {error}"
        raise ResultFileError(message) from None


def write_atomically(path: str | os.PathLike[str], write: Any) -> Path:
    """Call write(temporary path) in the target's folder, then put the file in its place.

    The content is on the disk before the name is: after a kill or a power cut there is the old
    file, the new one or none. Raises ResultFileError naming the file and the reason.
    """
    target = Path(path)
    place = None
    if "\0" in str(target):
        raise ResultFileError(f"{str(target)!r}: cannot be written: no name holds a zero character")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(
            dir=target.parent, prefix=f".{target.stem}-", suffix=target.suffix
        )
        os.close(handle)
        place = Path(name)
        write(place)
        place.chmod(0o666 & ~_umask())
        _flush(place)
        place.replace(target)
        _flush(target.parent)
    except OSError as error:
        message = f"{target}: cannot be written: {error.strerror or error}"
        raise ResultFileError(message) from None
    finally:
        if place is not None:
            place.unlink(missing_ok=True)
    return target


def _flush(path: Path) -> None:
    """Wait until a file, or the names in a folder, are on the disk."""
    if path.is_dir() and os.name == "nt":  # folders cannot be opened there
        return
    handle = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _umask() -> int:
    current = os.umask(0)
    os.umask(current)
    return current


def _plain(value: Any) -> Any:
    """NumPy values as JSON knows them."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else str(value)
