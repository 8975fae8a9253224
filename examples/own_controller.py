"""A controller of one's own: a class with one method that says what is wanted of the next step.

Letter I sways from side to side: its centre of mass follows a sine above the middle of its base.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

import warp_softbody as wsb
from warp_softbody.controllers import Goals, objectives
from warp_softbody.world.view import BodyView

PATCHES = tuple(f"base_patch_{corner}" for corner in range(4))
HEIGHT = 0.49  # m, of the centre of mass above the base


class Sway:
    """Moves the centre of mass along x by ``reach`` (m) to both sides in ``period`` (s)."""

    def __init__(self, reach: float = 0.03, period: float = 2.0) -> None:
        """Sway as far and as fast as asked for."""
        self.reach = reach
        self.period = period

    def goals(self, view: BodyView) -> Goals:
        """The momentum that leads to the goal, without much turning, on four contacts."""
        goal = view.positions[view.scene.character.region("base")].mean(axis=0)
        angle = 2.0 * math.pi * view.time / self.period
        goal += np.array([self.reach * math.sin(angle), 0.0, HEIGHT])
        # a spring of 100 1/s^2 and a damper of 10 1/s, times the mass
        rate = 100.0 * view.mass * (goal - view.center_of_mass) - 10.0 * view.linear_momentum
        return Goals(
            objectives=(
                objectives.linear_momentum(view, rate),
                objectives.angular_momentum(view, -6.0 * view.angular_momentum, weight=2.0),
            ),
            patches=wsb.controllers.ground_patches(view, PATCHES),
        )


def main(seconds: float = 2.0) -> npt.NDArray[np.float64]:
    """Path of the mean of all nodes along x, m, frame by frame."""
    scene = wsb.Scene(character=wsb.characters.letter_i(), ground=wsb.Plane(friction=0.8))
    simulation = wsb.Simulation(scene, controller=Sway(), time_step=0.01)
    return np.array([frame.positions[:, 0].mean() for frame in simulation.run(seconds)])


if __name__ == "__main__":
    for index, x in enumerate(main()):
        print(f"{index / 30:5.2f} s  {1e3 * x:+6.1f} mm")
