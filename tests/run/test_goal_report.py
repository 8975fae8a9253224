"""What was wanted, reached and reachable, and what muscles can do, against what physics allows."""

from __future__ import annotations

import json
import warnings
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.support.surfaces import BODIES
from warp_softbody import (
    Character,
    GoalReport,
    Plane,
    Scene,
    Simulation,
    characters,
    controllers,
    muscle_authority,
)
from warp_softbody.cli import main
from warp_softbody.controllers import Goals, objectives
from warp_softbody.errors import InputError, MeshWarning
from warp_softbody.world.view import BodyView

LETTER = characters.letter_i(coarse=1)


@cache
def table() -> Character:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        return Character.from_surface(BODIES["table"](), name="table", tets=900)


class Wish:
    """Wants the centre of mass to move, and nothing to turn."""

    def __init__(self, *rate: float) -> None:
        """A rate of momentum, body weights."""
        self.rate = np.array(rate)

    def goals(self, view: BodyView) -> Goals:
        """The momentum, and as little turning."""
        patches = tuple(f"base_patch_{corner}" for corner in range(4))
        return Goals(
            objectives=(
                objectives.linear_momentum(view, view.weight * self.rate),
                objectives.angular_momentum(view, np.zeros(3)),
            ),
            patches=controllers.ground_patches(view, patches),
        )


def report(scene: Scene, *rate: float, steps: int = 3) -> GoalReport:
    simulation = Simulation(scene, Wish(*rate), time_step=1 / 60)
    for _ in range(steps):
        simulation.step()
    return simulation.goal_report()


def test_a_small_wish_is_planned_and_reached() -> None:
    found = report(Scene(character=LETTER, ground=Plane()), 0.0, 0.0, 0.0)
    assert [own.objective for own in found.outcomes] == ["linear momentum"] * 3 + [
        "angular momentum"
    ] * 3
    for own in found.outcomes:
        assert own.low - 1e-3 <= own.planned <= own.high + 1e-3
        assert own.reached == pytest.approx(own.planned, abs=0.1)
        assert own.low <= own.reachable <= own.high
    assert "linear momentum 2" in str(found)


def test_more_than_muscles_have_is_told() -> None:
    """Rows are in m g dt: nothing here lifts a body with a hundred times its weight."""
    found = report(Scene(character=LETTER, ground=Plane()), 0.0, 0.0, 100.0)
    up = found.outcomes[2]
    assert up.wanted > 90.0
    assert up.reachable == up.high < 30.0


def test_muscles_move_no_centre_of_mass_in_the_air() -> None:
    """Without contact the weight alone changes the momentum: by -1 along z in each step."""
    scene = Scene(character=LETTER, ground=Plane(offset=-10.0))
    found = report(scene, 0.3, 0.0, 0.0, steps=2)
    for own, falls in zip(found.outcomes[:3], (0.0, 0.0, -2.0), strict=True):
        assert own.low == pytest.approx(falls, abs=2e-3)
        assert own.high == pytest.approx(falls, abs=2e-3)
        assert own.reached == pytest.approx(falls, abs=1e-3)


def test_nothing_to_report() -> None:
    simulation = Simulation(Scene(character=LETTER, ground=Plane()))
    simulation.step()
    with pytest.raises(InputError, match="no controller of 'scene' has decided in the last step"):
        simulation.goal_report()


def test_authority_of_mirrored_legs_is_mirrored() -> None:
    """Of a table, all fibres together pull it straight down."""
    body = table()
    every = muscle_authority(body)
    assert [own.name for own in every[:-1]] == [fiber.name for fiber in body.fibers]
    whole = every[-1]
    assert whole.centre_of_mass[2] < 0.0
    across = np.abs(whole.centre_of_mass[:2])
    assert across.max() < 0.05 * abs(whole.centre_of_mass[2])
    total = np.sum([own.centre_of_mass for own in every[:-1]], axis=0)
    np.testing.assert_allclose(total, whole.centre_of_mass, atol=1e-9)


def test_authority_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    surface, out = tmp_path / "table.stl", tmp_path / "table.char"
    BODIES["table"]().export(surface)
    line = ["character", str(surface), "-o", str(out), "--authority", "--tets", "600"]
    assert main([*line, "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert len(facts["authority"]) == facts["fibers"] + 1
    assert main(line) == 0
    assert "longitudinal_0_0 " in capsys.readouterr().out
