"""When a motion of a sequence took place, as it is told of a run."""

from __future__ import annotations

from dataclasses import dataclass, replace

from warp_softbody.inputs import checks


@dataclass(frozen=True, kw_only=True)
class MotionSpan:
    """When a motion of a sequence took place.

    Attributes:
        name: its own.
        begun: s.
        ended: s; None for one that goes on.
    """

    name: str
    begun: float
    ended: float | None = None

    def __str__(self) -> str:
        """In a few words."""
        end = "" if self.ended is None else f" to {self.ended:.4g} s"
        return f"{self.name} from {self.begun:.4g} s{end}"


def course_of(controller: object) -> tuple[MotionSpan, ...]:
    """The motions of a controller so far, in its own time; none where it tells of none."""
    label = f"course of a {type(controller).__name__}"
    return checks.items(label, getattr(controller, "course", ()), MotionSpan)


def with_inner_spans(span: MotionSpan, controller: object) -> tuple[MotionSpan, ...]:
    """Those within a motion, named "outer: inner", in the time of the outer one; or itself."""
    found = [
        replace(
            own,
            name=f"{span.name}: {own.name}",
            begun=span.begun + own.begun,
            ended=span.ended if own.ended is None else span.begun + own.ended,
        )
        for own in course_of(controller)
    ]
    return tuple(found) or (span,)
