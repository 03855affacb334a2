"""The [medium] table of a scene."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, PlainValidator

from flatland.injectors.values import check_number
from flatland.medium import Medium


def check_extinction(value: object) -> float:
    return check_number(value, 0.0)


def check_scattered(value: object) -> float:
    return check_number(value, 0.0, 1.0)


class MediumTable(BaseModel):
    """A medium that fills the whole grid and scatters light the same in all directions."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    extinction: Annotated[float, PlainValidator(check_extinction)] = Field(
        0.0, description="collisions per metre of flight [1/m]; 0 is a vacuum"
    )
    albedo: Annotated[float, PlainValidator(check_scattered)] = Field(
        0.0, description="share of the light that a collision scatters, 0 to 1; 0 is black"
    )

    @property
    def medium(self) -> Medium | None:
        """None for a vacuum."""
        return Medium(self.extinction, self.albedo) if self.extinction > 0 else None
