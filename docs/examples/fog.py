"""A propagator of one's own: DOM8 in fog. `python fog.py` runs it and checks its books."""

from __future__ import annotations

import numpy as np

import flatland
import propagators
from flatland.harmonics import AngularBasis
from flatland.stencil import Stencil
from propagators import Option, StencilPropagator


class Fog(StencilPropagator):
    """In every step, the share s of the light is scattered evenly; then all of it steps as DOM8.

    T_d = D_d (1 − s + s P₀), with D_d the matrices of DOM8 and P₀ = diag(1, 0, 0, …), which keeps
    flux and forgets directions. Conserves flux, as both factors do.

    What it gets wrong: what DOM8 does; and a diagonal step, though longer, scatters no more.
    """

    name = "fog"
    summary = "DOM8 in fog that scatters light evenly"
    options = (Option("share", float, 0.2, "scattered in a step", minimum=0.0, maximum=1.0),)

    def _build(self, basis: AngularBasis) -> Stencil:
        dom8 = propagators.create("dom8").stencil(basis)
        kept = np.full(basis.size, 1 - self.values["share"])
        kept[0] = 1.0
        return Stencil(basis, dom8.offsets, dom8.transfer * kept)


if __name__ == "__main__":
    scene = flatland.load_scene("shelf")
    for share in (0.0, 0.1, 1.0):
        simulation = flatland.Simulation(scene, Fog(share=share), bands=4)
        simulation.solve()
        books = simulation.ledger
        assert abs(books.emitted - books.left - books.absorbed) < 1e-6 * books.emitted
        print(f"scattered {share:.1f}: {float(books.absorbed):5.2f} W end on the shelf")
