"""What a summary finds of a run's shape, momentum and unsettled steps."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.support.bodies import box
from warp_softbody import Character, Material, Plane, Scene, Simulation, SimulationOptions
from warp_softbody.cli import main
from warp_softbody.run.run_account import Findings
from warp_softbody.run.run_summary import RunSummary


def summary(young_modulus: float, seconds: float = 1.0, height: float = 0.0) -> RunSummary:
    """Of a cube of 0.1 m that falls on the ground."""
    material = Material(young_modulus=young_modulus, poisson_ratio=0.3)
    mesh = box((3, 3, 3), (0.1, 0.1, 0.1), (0.0, 0.0, height))
    body = Character(name="cube", mesh=mesh, material=material)
    simulation = Simulation(Scene(character=body, ground=Plane()))
    for _ in simulation.run(seconds):
        pass
    return simulation.summary()


def test_a_sound_run_has_no_doubts() -> None:
    found = summary(1e6)
    assert found.status == "complete" and found.findings.doubts == ()
    assert found.findings.momentum_error < 1e-3
    assert found.findings.inverted_tets == found.findings.most_inverted == 0
    least, largest = found.findings.volumes
    assert 0.98 < least <= largest < 1.001
    assert found.findings.depth < 1e-6
    assert found.findings.unsettled is None


def test_a_crushed_body_is_doubtful() -> None:
    """Its own weight is as large as its modulus."""
    found = summary(500.0, height=0.1)
    assert found.status == "doubtful" and "doubtful" in str(found)
    assert found.findings.inverted_tets > 0
    assert any("inside out" in doubt for doubt in found.findings.doubts)
    assert any("times its volume" in doubt for doubt in found.findings.doubts)


def test_measured_shapes_are_those_of_the_frame() -> None:
    mesh = box((2, 2, 2), (0.1, 0.1, 0.1))
    simulation = Simulation(Scene(character=Character(name="cube", mesh=mesh)))
    squeezed = mesh.points * [1.0, 1.0, 0.5]
    squeezed[0] += 0.2
    simulation.state.positions.assign(squeezed)
    frame = next(simulation.run(1.0))
    corners = frame.positions[mesh.tets]
    volumes = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0
    shapes = simulation.shapes
    assert shapes.volumes[0] == pytest.approx(volumes.sum() / mesh.volume, rel=1e-5)
    assert shapes.inverted[0] == np.count_nonzero(volumes <= 0.0) > 0


def test_the_command_line_tells(capsys: pytest.CaptureFixture[str]) -> None:
    """Code 4, a status of its own, and the doubts on stderr where the summary is not read."""
    settings = ["--set", "young_modulus=1000", "--set", "cells=3", "--seconds", "1", "--quiet"]
    assert main(["run", "drop-block", *settings, "--json"]) == 4
    told = capsys.readouterr()
    found = json.loads(told.out)
    assert found["status"] == "doubtful" and found["precision"] == "float32"
    assert set(found["findings"]) == set(Findings.__dataclass_fields__)
    assert "warp-softbody: in doubt: " in told.err


def test_momentum_from_nowhere_stops_a_run() -> None:
    """Single precision cannot hold this matrix; the run says so instead of going on."""
    material = Material(young_modulus=1e10, poisson_ratio=0.49, stiffness_damping=5.0)
    body = Character(name="cube", mesh=box((4, 4, 4), (0.1, 0.1, 0.1)), material=material)
    scene = Scene(character=body, ground=Plane(friction=0.3), initial_velocity=(60.0, 0.0, 0.0))
    options = SimulationOptions(precision="float32", time_step=0.007)
    simulation = Simulation(scene, options=options, fps=1.0 / 0.007)
    try:
        for frame in simulation.run(0.5):
            last = frame
    except Exception as error:
        assert "float64" in str(error)
    found = simulation.summary()
    assert found.status in ("not finite", "doubtful")
    assert any("float32" in doubt for doubt in found.findings.doubts)
    assert np.isfinite(last.positions).all()
