"""Exact answers that many cases share: computed once, kept beside the cases."""

from __future__ import annotations

import hashlib
import zipfile
from collections import OrderedDict
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flatland.errors import ResultFileError
from flatland.field import Field
from flatland.harmonics import basis_for
from flatland.results import write_atomically
from studies.reference import DIRECTIONS, Reference
from studies.sweeps.code import code_version
from studies.sweeps.scenes import StudyScene

Array = NDArray[np.float64]

#: Files larger than this are not worth it [B]: reading them costs what computing does.
LARGEST = 256 * 2**20
#: References kept in memory by a process; cases of one scene follow each other.
_KEPT = 2
_recent: OrderedDict[str, StoredReference] = OrderedDict()


class StoredReference(Reference):
    """A reference that begins with arrays from a file.

    coefficients: ([colours,] size, *shape) at some number of bands. intensity: None where there is
    no density over angle.
    """

    def __init__(
        self,
        scene: StudyScene,
        bounces: bool,
        coefficients: Array,
        bands: int,
        intensity: Array | None,
    ) -> None:
        loaded = scene.load()
        super().__init__(loaded, bounces=bounces)
        self._fields[bands] = Field(
            loaded.grid, basis_for(loaded.grid.dimension, bands), coefficients
        )
        self.bands, self._stored = bands, intensity

    @cached_property
    def intensity(self) -> Array:
        return super().intensity if self._stored is None else self._stored


def reference_key(scene: StudyScene, bounces: bool) -> str:
    """A name for the exact answer of a scene: SHA-256 over all that it depends on."""
    content = f"{scene.digest} {bounces} {DIRECTIONS} {code_version()}"
    return hashlib.sha256(content.encode()).hexdigest()[:20]


def shared_reference(scene: StudyScene, bounces: bool, bands: int, folder: str) -> StoredReference:
    """The exact answer, from memory, from its file, or computed and kept.

    folder: "" keeps nothing on disk. A damaged file is computed again; that a file cannot be
    written harms nobody. Raises what the analytic propagator raises.
    """
    key = reference_key(scene, bounces)
    path = Path(folder) / f"{key}.npz" if folder else None
    known = _recent.get(key)
    if known is None or known.bands < bands:
        known = _read(path, scene, bounces) if path else None
    if known is None or known.bands < bands:
        known = _compute(scene, bounces, bands)
        _keep(path, known)
    elif path and not path.exists():
        _keep(path, known)
    _recent[key] = known
    _recent.move_to_end(key)
    while len(_recent) > _KEPT:
        _recent.popitem(last=False)
    return known


def has_reference(scene: StudyScene, bounces: bool, bands: int, folder: str) -> bool:
    """Whether a good file with so many bands is there."""
    known = _read(Path(folder) / f"{reference_key(scene, bounces)}.npz", scene, bounces)
    return known is not None and known.bands >= bands


def _compute(scene: StudyScene, bounces: bool, bands: int) -> StoredReference:
    plain = Reference(scene.load(), bounces=bounces)
    coefficients = np.asarray(plain.field(bands).values, float)
    intensity = plain.intensity if plain.has_density else None
    return StoredReference(scene, bounces, coefficients, bands, intensity)


def _read(path: Path, scene: StudyScene, bounces: bool) -> StoredReference | None:
    """None if there is no file, or none whose checksums (of the zip archive) are right."""
    try:
        # NumPy leaves a damaged file open.
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            intensity = file["intensity"] if "intensity" in file.files else None
            return StoredReference(
                scene, bounces, file["coefficients"], int(file["bands"]), intensity
            )
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None


def _keep(path: Path | None, reference: StoredReference) -> None:
    if path is None or not path.parent.is_dir():  # a worker of a cluster may not see the folder
        return
    arrays: dict[str, Array] = {
        "coefficients": np.asarray(reference.field(reference.bands).values),
        "bands": np.asarray(reference.bands),
    }
    if reference._stored is not None:
        arrays["intensity"] = reference._stored
    if sum(array.nbytes for array in arrays.values()) > LARGEST:
        return

    def write(place: Path) -> None:
        with place.open("wb") as file:
            np.savez(file, **arrays)  # type: ignore[arg-type]

    try:
        write_atomically(path, write)
    except ResultFileError:
        return
