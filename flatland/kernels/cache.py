"""How much the processor's last cache holds."""

from __future__ import annotations

import os
from functools import cache

#: Where the system does not tell.
_USUAL = 32 * 2**20


@cache
def last_cache_bytes() -> int:
    """Bytes of the largest cache; a guess where the system does not tell."""
    try:
        return max(os.sysconf("SC_LEVEL3_CACHE_SIZE"), os.sysconf("SC_LEVEL2_CACHE_SIZE")) or _USUAL
    except (AttributeError, OSError, ValueError):
        return _USUAL
