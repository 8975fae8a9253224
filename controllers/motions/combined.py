"""Several controllers at once: one that stands, and others that want something beside it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from warp_softbody.controllers.arguments import remembered
from warp_softbody.controllers.controller import Controller, Goals, seen
from warp_softbody.controllers.inner_controllers import says, told_by, two_with_one
from warp_softbody.controllers.motions.composition import weighed
from warp_softbody.controllers.motions.motion_span import MotionSpan, course_of
from warp_softbody.controllers.objectives import Objective
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.inputs.records import unchecked_copy
from warp_softbody.world.view import BodyView

Wish = Callable[[BodyView], "Objective | Iterable[Objective]"]
"""A function of a view that returns an objective or several."""


@remembered
class Combined:
    """What several controllers want of each step, at once.

    The contacts that the plan may use, the cost of the activations and the segments that may not
    contract are those of the first; of the others the objectives are added. Where the first wants
    nothing, the body is limp.
    """

    def __init__(
        self,
        together: Iterable[Controller | Wish],
        *,
        weights: Iterable[float] | None = None,
    ) -> None:
        """Combine controllers; all but the first may be functions of a view.

        Args:
            together: controllers, or functions of a `BodyView` that return an `Objective` or
                several; the first is a controller.
            weights: by which the objectives of each count, 1 each where none are given.

        Raises:
            InputError: there are none, not as many weights, or one controller twice.
        """
        given = checks.several("together of Combined", together, "controllers")
        if not given:
            raise InputError("together of Combined must hold a controller at least")
        self._first: Controller = told_by(
            input_kinds.controller("together[0] of Combined", given[0])
        )
        self._others = [_checked(number + 1, own) for number, own in enumerate(given[1:])]
        self._weights = _checked_weights(weights, len(given))
        if two_with_one([own] for own in self.controllers):
            raise InputError(
                "two of together of Combined have one controller, which remembers its steps; "
                "make one for each"
            )

    @property
    def together(self) -> tuple[Controller | Wish, ...]:
        """All of them."""
        return (self._first, *(own for own, _ in self._others))

    @property
    def controllers(self) -> tuple[Controller, ...]:
        """Those of them that are controllers."""
        return (self._first, *(own for own, is_wish in self._others if not is_wish))

    @property
    def course(self) -> tuple[MotionSpan, ...]:
        """The motions that have begun in any of them, in the order of their times."""
        spans = [span for own in self.controllers for span in course_of(own)]
        return tuple(sorted(spans, key=lambda span: span.begun))

    @property
    def weights(self) -> tuple[float, ...]:
        """By which the objectives of each count."""
        return self._weights

    @property
    def keeps_upright(self) -> bool:
        """Whether the first does."""
        return says(self._first, "keeps_upright")

    @property
    def finished(self) -> bool:
        """Whether the first has."""
        return says(self._first, "finished")

    @property
    def interruptible(self) -> bool:
        """Whether the first is."""
        return says(self._first, "interruptible", otherwise=True)

    def begin(self, view: BodyView, standing: BodyView) -> None:
        """Tell all that a motion begins, as a `Sequence` does."""
        for own in self.controllers:
            told(own, view, standing)

    def goals(self, view: BodyView) -> Goals | None:
        """Objectives of the step from ``view`` on."""
        view = seen(view)
        goals = self._first.goals(view)
        added: list[Objective] = []
        for (own, is_wish), weight in zip(self._others, self._weights[1:], strict=True):
            added += weighed(_objectives(own(view) if is_wish else own.goals(view)), weight)
        if goals is None:
            return None
        return unchecked_copy(
            goals, objectives=(*weighed(goals.objectives, self._weights[0]), *added)
        )


def told(controller: Any, view: BodyView, standing: BodyView) -> None:
    """Tell a controller that its motion begins: by its `begin`, else by a first question.

    Args:
        controller: that begins.
        view: the body as it is, its time from the beginning of the motion.
        standing: the body at rest where it is; from this what has no ``begin`` takes heights and
            places, which it remembers of the first view that it sees.
    """
    if hasattr(controller, "begin"):
        controller.begin(view, standing)
    else:
        controller.goals(standing)


def _checked(number: int, given: object) -> tuple[Any, bool]:
    """A controller or a wish, and whether it is a wish."""
    label = f"together[{number}] of Combined"
    if not callable(getattr(given, "goals", None)) and callable(given):
        return checks.called_with(label, given, 1, "a controller or a function of a view"), True
    return told_by(input_kinds.controller(label, given)), False


def _checked_weights(weights: object, count: int) -> tuple[float, ...]:
    if weights is None:
        return (1.0,) * count
    given = checks.several("weights of Combined", weights, "numbers")
    if len(given) != count:
        raise InputError(
            f"weights of Combined must be {count} numbers, one for each controller, not "
            f"{len(given)}"
        )
    return tuple(
        checks.number(f"weights[{i}] of Combined", weight, low=0.0)
        for i, weight in enumerate(given)
    )


def _objectives(wanted: Any) -> tuple[Objective, ...]:
    """Those of goals, of an objective, or of several."""
    if wanted is None:
        return ()
    if isinstance(wanted, Goals):
        return wanted.objectives
    given = (wanted,) if isinstance(wanted, Objective) else wanted
    return checks.items("what a function in Combined returns", given, Objective)
