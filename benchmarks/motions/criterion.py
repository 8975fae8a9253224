"""A motion read from its stage, and numbers of it with their bounds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from warp_softbody.body.character import Character
from warp_softbody.stage_exports import measure, read_take
from warp_softbody.stage_exports.measures import Measures
from warp_softbody.stage_exports.usd.reader import Take


@dataclass(frozen=True)
class RecordedMotion:
    """A run as its stage shows it, and the character whose regions name parts of it."""

    take: Take
    character: Character

    @classmethod
    def read(cls, stage: Path, character: Character) -> RecordedMotion:
        """The first body of a stage."""
        return cls(read_take(stage), character)

    @cached_property
    def measures(self) -> Measures:
        """Of every frame."""
        return measure(self.take)


@dataclass(frozen=True)
class Criterion:
    """A number of a motion and its bound.

    Attributes:
        name: what it is.
        of: the number.
        bound: that it has to reach, or must not reach.
        at_least: which of the two.
        form: how the number is written.
    """

    name: str
    of: Callable[[RecordedMotion], float]
    bound: float
    at_least: bool = True
    form: str = "{:.2f} m"

    def holds(self, value: float) -> bool:
        """Whether a number is what is asked; what is no number never is."""
        return bool(value >= self.bound if self.at_least else value < self.bound)

    def text(self, value: float) -> str:
        """A number with its unit."""
        return self.form.format(value)


@dataclass(frozen=True)
class Finding:
    """The number of one criterion in one motion."""

    criterion: Criterion
    value: float

    @property
    def holds(self) -> bool:
        """Whether it is what is asked."""
        return self.criterion.holds(self.value)

    def __str__(self) -> str:
        """As it stands in a table of what fails."""
        return f"{self.criterion.name} {self.criterion.text(self.value)}"


def below(
    name: str, measured: Callable[[RecordedMotion], float], bound: float, form: str = "{:.2f} m"
) -> Criterion:
    """A number that must stay below its bound."""
    return Criterion(name, measured, bound, at_least=False, form=form)
