"""What Qt needs of the system, checked before Qt aborts for want of it."""

from __future__ import annotations

import ctypes
import os
import sys
from pathlib import Path

from flatland.errors import FlatlandError

_FOR_WINDOWS = (
    "libxcb-cursor0 libxcb-icccm4 libxcb-image0 libxcb-keysyms1 libxcb-render-util0 "
    "libxkbcommon-x11-0"
)
_FOR_QT = "libegl1 libgl1 libxkbcommon0 libdbus-1-3 libfontconfig1 libglib2.0-0"
_WITHOUT = "--screenshot FILE.png works without"


def require_display() -> None:
    """Raise FlatlandError where there is no display, or nothing to talk to one with."""
    needs = sys.platform.startswith("linux") and "QT_QPA_PLATFORM" not in os.environ
    if not needs or os.environ.get("WAYLAND_DISPLAY"):
        return
    if not os.environ.get("DISPLAY"):
        raise FlatlandError(f"there is no display here; {_WITHOUT} one")
    missing = missing_for(_x11_plugin())
    if missing:
        message = (
            f"Qt cannot open a window ({missing}). On Debian and Ubuntu: apt-get install "
            f"{_FOR_WINDOWS}; {_WITHOUT}"
        )
        raise FlatlandError(message)


def _x11_plugin() -> Path:
    from PySide6.QtCore import QLibraryInfo

    plugins = Path(QLibraryInfo.path(QLibraryInfo.LibraryPath.PluginsPath))
    return plugins / "platforms" / "libqxcb.so"


def missing_for(plugin: Path) -> str:
    """What a shared library misses of the system, as the loader says; "" if nothing."""
    try:
        if plugin.exists():
            ctypes.CDLL(str(plugin))
    except OSError as error:
        return str(error)
    return ""


def missing_library(error: ImportError) -> str:
    """What to install when Qt does not load."""
    return f"Qt cannot be loaded ({error}). On Debian and Ubuntu: apt-get install {_FOR_QT}"
