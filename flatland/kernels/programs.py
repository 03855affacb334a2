"""The programs of one sweep, each compiled when it is first needed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.arrivals import written_operations
from flatland.kernels.assembly import SweepText
from flatland.kernels.border import outflow_text
from flatland.kernels.box import Box, sweep_box, whole
from flatland.kernels.compiler import compile_text
from flatland.kernels.layout import Layout
from flatland.kernels.recipe import Recipe
from flatland.kernels.stepping import stepping_text
from flatland.stencil import Stencil

Program = Callable[..., None]

#: Multiply-adds, of light that is not there, in the time that it takes to compile other steps.
_COMPILING = 200_000_000
#: Operations of a step over the whole grid from which steps for a box are compiled before the
#: first one.
_LARGE_STEP = 10_000_000
#: Whole planes are taken for a box that has all but one part in so many of their cells.
_WORTH_A_BOX = 3


class Programs:
    """Steps of whole planes and of boxes, and combinations, for one stencil on one layout.

    border_weights: of cells that light leaves the grid from, see `border`.
    """

    def __init__(
        self,
        stencil: Stencil,
        layout: Layout,
        recipe: Recipe,
        border_weights: NDArray[np.float64],
    ) -> None:
        self._stencil, self._layout, self._recipe = stencil, layout, recipe
        self._border_weights = border_weights
        self._operations = written_operations(stencil)
        self.rows, self.whole_box = sweep_box(layout, whole(layout.shape))
        #: What was compiled, kept as long as it may be called.
        self.code: list[object] = []
        self._wasted = 0

    @cached_property
    def steps(self) -> Program:
        return self._steps(self._recipe)

    @cached_property
    def steps_in_box(self) -> Program:
        return self._steps(replace(self._recipe, boxed=True, large=False))

    @cached_property
    def steps_anywhere(self) -> Program:
        """For buffers that do not begin on a vector."""
        return self._steps(replace(self._recipe, large=False))

    @cached_property
    def combine(self) -> Program:
        return self._compiled(self._text(replace(self._recipe, kind="combine")), "sweep")

    def prepare(self, lit: Box) -> None:
        """Compile steps for a box ahead, where it is a part of a large grid."""
        work = math.prod(self._layout.shape) * self._operations
        if work > _LARGE_STEP and lit != whole(self._layout.shape):
            _ = self.steps_in_box

    def for_box(self, lit: Box, count: int) -> tuple[Program, range, NDArray[np.int64]]:
        """Steps for a box, the rows that they count, and their place.

        Whole planes take the steps that know how long a row is. Those for any box are compiled
        once the work that they would have saved is as much as compiling them.
        """
        in_box, box = sweep_box(self._layout, lit)
        per_plane = self.rows // self._layout.shape[0]
        planes = range(lit[0][0] * per_plane, lit[0][1] * per_plane)
        spared = len(planes) * self._layout.width - in_box * int(box[4] - box[3])
        self._wasted += count * max(0, spared) * self._operations
        paid = self._wasted > _COMPILING or "steps_in_box" in self.__dict__
        if spared * _WORTH_A_BOX > len(planes) * self._layout.width and paid:
            return self.steps_in_box, range(in_box), box
        return self.steps, planes, self.whole_box

    def _steps(self, recipe: Recipe) -> Program:
        text = self._text(recipe) + outflow_text(self._layout, self._border_weights)
        mirrors = any(self._layout.mirrors)
        return self._compiled(text + stepping_text(len(recipe.sums) + 2, mirrors), "steps")

    def _text(self, recipe: Recipe) -> str:
        return SweepText(self._stencil, self._layout, recipe).text()

    def _compiled(self, text: str, name: str) -> Program:
        code = compile_text(text)
        self.code.append(code)
        return code.function(name)
