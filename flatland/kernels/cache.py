"""How much the processor's last cache holds."""

from __future__ import annotations

import os
from functools import cache

#: Where the system does not tell.
_USUAL = 32 * 2**20


@cache
def last_cache_bytes() -> int:
    """Bytes of the third level; a guess where the system does not tell, or tells 0."""
    try:
        told = os.sysconf("SC_LEVEL3_CACHE_SIZE")
    except (AttributeError, OSError, ValueError):
        return _USUAL
    return told if told > 0 else _USUAL
