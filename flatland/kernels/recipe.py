"""What a sweep is to do with the light that arrives."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Recipe:
    """What a sweep does with A S, the light that arrives.

    kind="step": T = A S, X += T, and sums of components over the row.
    kind="combine": T = f₀·S + f₁·X + f₂·(A S), X read only, f₀, f₁, f₂ given in `sums`.
    blocked: τ(x, d) multiplies what leaves x along d.
    boxed: rows and columns are those of a box given at run time; costs a little per row, since
    their numbers are not known when the text is compiled.
    large: source, target and total together do not fit into the cache. What is written then goes
    past it, for buffers that begin on a vector; in space, a row at a time.
    """

    kind: str = "step"
    blocked: bool = False
    boxed: bool = False
    large: bool = False
    #: Components whose sum over cells is returned (the sum of all squares comes last).
    sums: tuple[int, ...] = (0,)
