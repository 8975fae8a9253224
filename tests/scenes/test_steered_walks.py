"""Walks that are steered: on the spot, aside, to a stop and along a figure of eight."""

from __future__ import annotations

import math
import warnings
from pathlib import Path

import numpy as np
import pytest

from tests.scenes.runs import missed, run
from tests.support.surfaces import BODIES
from warp_softbody import Character, Plane, Scene, Simulation
from warp_softbody.controllers import DIAGONAL_PAIRS, Steering, Trail, Walk
from warp_softbody.controllers.controller import Controller
from warp_softbody.controllers.motions.body_measures import angle_turned
from warp_softbody.controllers.motions.steering import Guide
from warp_softbody.errors import InputError, MeshWarning
from warp_softbody.scenes.walk_x import STEERED, walking_letter
from warp_softbody.world.view import BodyView


def moved(
    controller: Controller, seconds: float, body: Character | None = None
) -> tuple[BodyView, float]:
    """The last view of a run, and by how much (rad) the body has turned about the vertical."""
    character = walking_letter(coarse=1) if body is None else body
    simulation = Simulation(
        Scene(character=character, ground=Plane()), controller, time_step=1.0 / 60.0
    )
    turned = before = 0.0
    while simulation.time < seconds - 1e-6:
        simulation.step()
        angle = angle_turned(simulation.view(), 0, 1)
        turned, before = turned + math.remainder(angle - before, math.tau), angle
    return simulation.view(), turned


def steered(steering: Guide | None) -> Walk:
    return Walk(STEERED, gait=DIAGONAL_PAIRS, steering=steering)


def test_it_turns_on_the_spot() -> None:
    view, turned = moved(steered(Steering(forward=0.0, turning=0.5)), 6.0)
    # it sets out at 0.3 s and takes a swing or two to hasten
    assert 0.5 * 4.5 < turned < 0.5 * 5.8
    assert np.hypot(*view.center_of_mass[:2]) < 0.05


def test_it_goes_aside_and_stops() -> None:
    aside = Steering(forward=0.0, aside=0.25)
    walk = steered((aside, Steering(forward=0.0, start=4.0)))
    view, turned = moved(walk, 8.0)
    assert view.center_of_mass[1] > 0.25 * 3.0
    assert abs(view.center_of_mass[0]) < 0.1
    assert abs(turned) < 0.1
    # all feet are down, and it stands
    assert np.hypot(*(view.linear_momentum / view.mass)[:2]) < 0.02
    assert abs(view.velocities).max() < 0.05


def test_a_script_steers_it_while_it_walks() -> None:
    walk = steered(lambda view: Steering(forward=0.2 if view.time < 3.0 else -0.2))
    view, _ = moved(walk, 7.0)
    other = steered(None)
    other.steer(0.2)
    ahead, _ = moved(other, 3.0)
    assert view.center_of_mass[0] < ahead.center_of_mass[0] - 0.2


def test_more_than_its_feet_can_do_is_refused() -> None:
    with pytest.raises(InputError, match="this walk moves its feet by at most"):
        moved(steered(Steering(forward=2.0)), 1.0)


def test_any_body_is_steered() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        table = Character.from_surface(BODIES["table"](), name="table")
    turning = Walk.for_(table, steering=Steering(forward=0.0, turning=0.4))
    view, turned = moved(turning, 5.0, table)
    assert 1.0 < turned < 2.0
    start = table.mesh.points.mean(axis=0)
    assert np.hypot(*(view.center_of_mass - start)[:2]) < 0.1
    with pytest.raises(InputError, match="Walk takes a speed or a steering, not both"):
        Walk.for_(table, speed=0.1, steering=Steering())


@pytest.mark.long
def test_it_walks_a_figure_of_eight(tmp_path: Path) -> None:
    motion = run("walk-x-eight", tmp_path)
    assert missed("walk-x-eight", motion) == []
    # it ends where it began, after a turn to the left and one to the right
    path = motion.measures.centre_of_mass[:, :2]
    assert math.dist(path[-1], path[0]) < 0.15
    assert path[:, 1].max() > 1.1
    assert path[:, 1].min() < -1.1


def test_what_is_refused_under_way_leaves_the_last_guide() -> None:
    """A trail goes on to its end after a speed that the feet cannot reach was asked for."""
    walk = steered(Trail(points=np.array([(0.0, 0.0), (0.2, 0.0)])))
    moved(walk, 0.5)
    with pytest.raises(InputError, match="this walk moves its feet by at most"):
        walk.steer(9.0)
    assert walk.finished is False
