"""Small files, written whole or not at all."""

from __future__ import annotations

from pathlib import Path


def store_text(path: Path, text: str) -> Path:
    """Write UTF-8 text. Raises ResultFileError."""
    return store_bytes(path, text.encode("utf-8"))


def store_bytes(path: Path, content: bytes) -> Path:
    """Write bytes. Raises ResultFileError."""
    # Imported here: results bring xarray along, half a second that a window need not wait for.
    from flatland.results import write_atomically

    return write_atomically(path, lambda place: place.write_bytes(content))
