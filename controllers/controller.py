"""What a locomotion controller is: a class that says what it wants of the next step."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

from warp_softbody.controllers.objectives import Objective
from warp_softbody.controllers.patches import Patch
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.world.view import BodyView


@dataclass(frozen=True, kw_only=True)
class ActivationCost:
    """What activations a = l_d / l_0 cost, each averaged over the segments.

    Attributes:
        effort: weight of (a - 1)^2, keeps unused muscles relaxed.
        change: weight of the rate of a, in sqrt(L/g): of (a - a_before)^2 it is this over the
            time step, so that it means the same at any step. Keeps motion smooth.
    """

    effort: float = 0.02
    change: float = 0.15

    def __post_init__(self) -> None:
        """Refuse weights that would leave the problem without a unique answer."""
        checks.settle(self, not_negative=("effort", "change"))
        if self.effort + self.change <= 0.0:
            raise InputError("activation effort and change must not both be zero")


@dataclass(frozen=True, kw_only=True)
class Goals:
    """What is wanted of one step.

    Attributes:
        objectives: weighted squares of linear functions of v+.
        patches: contacts that the plan may use.
        activation: cost of the activations.
        resting: segments that may not contract.
        nominal: activations, one a segment, from which changes are counted; empty for those of the
            last step.
    """

    objectives: tuple[Objective, ...]
    patches: tuple[Patch, ...] = ()
    activation: ActivationCost = field(default_factory=ActivationCost)
    resting: tuple[int, ...] = ()
    nominal: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Refuse entries that are no objectives, patches or segments."""
        checks.keep(
            self,
            objectives=checks.items("Goals.objectives", self.objectives, Objective),
            patches=checks.items("Goals.patches", self.patches, Patch),
            activation=checks.instance("Goals.activation", self.activation, ActivationCost),
            resting=segments("Goals.resting", self.resting),
            nominal=_activations("Goals.nominal", self.nominal),
        )


def _activations(label: str, value: object) -> tuple[float, ...]:
    given = checks.several(label, value, "a tuple of activations")
    return tuple(
        checks.number(f"{label}[{i}]", each, low=0.0, high=1.0) for i, each in enumerate(given)
    )


def segments(label: str, value: object) -> tuple[int, ...]:
    """Indices of muscle segments, in a tuple."""
    if type(value) is tuple and all(type(index) is int and index >= 0 for index in value):
        return value
    given = checks.several(label, value, "a tuple of segment indices")
    return tuple(checks.whole(f"{label}[{i}]", index) for i, index in enumerate(given))


def seen(view: object) -> BodyView:
    """The view that a controller was asked for."""
    return checks.instance("the view of a controller", view, BodyView)


class Controller(Protocol):
    """One method; a user's own controller needs no base class.

    Those of `controllers.motions` keep phases, heights and units of the body that they see
    first: an instance is for one run. Where an attribute ``keeps_upright`` is true, at the start
    and at the end, a run in which its body falls ends as doubtful; where ``plans_single_steps`` is,
    of it or of one among its `controllers`, plans look one step ahead; a `Sequence` looks at
    `finished`, `interruptible` and `begin` (docs/sequences.md).
    """

    def goals(self, view: BodyView) -> Goals | None:
        """What is wanted of the step from ``view`` on; None leaves every muscle slack."""
        ...
