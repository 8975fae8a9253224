"""What can be steered while it goes."""

from __future__ import annotations

from abc import ABC, abstractmethod

from warp_softbody.controllers.motions.steering import Guide, Steering, SteeringShares, Trail


class Steerable(ABC):
    """A motion whose guide may be another one from the next step on."""

    _guide: Guide | None

    @property
    def finished(self) -> bool:
        """Whether the last point of its trail is reached.

        Raises:
            AttributeError: it follows no trail, so that it has no end.
        """
        if not isinstance(self._guide, Trail):
            raise AttributeError("only a walk along a trail comes to an end")
        return self._has_arrived()

    def steer(
        self, forward: float | None = None, *, aside: float = 0.0, turning: float = 0.0
    ) -> None:
        """Go on like this from the next step on.

        Args:
            forward: m/s, along the heading; None is the speed for which the gains are made.
            aside: m/s, to the left of that.
            turning: rad/s about the vertical, to the left.
        """
        self._be_guided(Steering(forward=forward, aside=aside, turning=turning))

    def steer_by(self, *, forward: float = 0.0, aside: float = 0.0, turning: float = 0.0) -> None:
        """Go on like this from the next step on: shares, -1 to 1, of what the feet can do."""
        self._be_guided(SteeringShares(forward=forward, aside=aside, turning=turning))

    @abstractmethod
    def _be_guided(self, guide: Guide) -> None:
        """Follow another guide; one that asks for too much is refused, and the last one stays."""

    @abstractmethod
    def _has_arrived(self) -> bool:
        """Whether a trail was followed to its end."""
