"""The documentation's own modules and examples can be imported."""

import sys
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"
sys.path[:0] = [str(DOCS / "extensions"), str(DOCS / "examples")]
