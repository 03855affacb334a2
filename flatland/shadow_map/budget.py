"""Where the flux of a lamp goes before it is reflected."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Flux = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LightBudget:
    """Flux [W] per colour, (max(1, colours),): emitted = received + escaped.

    emitted: sent into the grid. received: arrives at surfaces. absorbed: the part of that which
    surfaces keep. escaped: leaves the grid without meeting a surface. Exact, whatever a stencil
    makes of the same light.
    """

    emitted: Flux
    received: Flux
    absorbed: Flux
    escaped: Flux

    @property
    def reflected(self) -> Flux:
        """What surfaces send back, the first bounce [W]."""
        return self.received - self.absorbed
