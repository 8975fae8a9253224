"""The beam benchmark says what it is meant to; its times are not tested."""

from __future__ import annotations

import json
import sys
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from benchmarks.beam import command as beam
from benchmarks.beam.cantilever import TIME_STEP, cantilever
from benchmarks.beam.rounds import Entrant, run_in_turn
from benchmarks.beam.solver import static_sag
from benchmarks.beam.table import BeamResult
from warp_softbody import SimulationOptions
from warp_softbody.accuracy.runs.peers.beam import MATERIAL, StepReport
from warp_softbody.accuracy.runs.peers.corotation import CorotationalSystem
from warp_softbody.arrays import FloatArray
from warp_softbody.engine.options import Precision

STEPS = 7
UNTIMED_STEPS = 2


def residual_bound(precision: Precision) -> float:
    """Largest residual that the options allow a timed step of the 810-tet beam, and rounding adds.

    The solve stops at the tolerance times |b| with the clamped nodes' rows in b. It knows A and b
    in its own precision only, unit roundoff u, and does not see what their rounding adds:
    - A v+: entries and sums of about 10 roundings each, 10 u | |A| |v+| |.
    - forces: a strain is a product of two matrices near one (F = Ds Dm^-1 with Dm^-1 rounded, then
      R^T F) less one, about 8 roundings of a number near one; so a corner's force is off by 8 u (2
      mu + 3 lambda) V |g|. Those of different corners are independent and add up in squares.
    """
    body = cantilever(810)
    system = CorotationalSystem(body, TIME_STEP)
    u = float(np.finfo(precision).eps) / 2.0
    slopes = body.mesh.volumes[:, None] * np.linalg.norm(system.gradients, axis=2)
    modulus = 2.0 * MATERIAL.lame_mu + 3.0 * MATERIAL.lame_lambda
    force = 8.0 * u * modulus * float(np.linalg.norm(slopes))
    tolerance = SimulationOptions(precision=precision).solver_tolerance
    positions, velocities = body.mesh.points.copy(), np.zeros_like(body.mesh.points)
    bounds = []
    for _ in range(UNTIMED_STEPS + STEPS):
        matrix, b = system.assemble(positions, velocities)
        right = b.ravel()[system.free]
        solution = spsolve(matrix, right)
        product = float(np.linalg.norm(abs(matrix) @ abs(solution)))
        allowed = tolerance * np.linalg.norm(b) + 10.0 * u * product + TIME_STEP * force
        bounds.append(float(allowed / np.linalg.norm(right)))
        velocities.ravel()[system.free] = solution
        positions = positions + TIME_STEP * velocities
    return max(bounds[UNTIMED_STEPS:])


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> list[dict[str, Any]]:
    """The objects that the command prints."""
    beam.main(["--tets", "810", "--steps", str(STEPS), "--json", *arguments])
    objects = json.loads(capsys.readouterr().out)
    assert isinstance(objects, list)
    return objects


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_our_beam_solves_its_system_and_sags_as_it_should(
    precision: Precision, capsys: pytest.CaptureFixture[str]
) -> None:
    (result,) = run(capsys, "--precision", precision)
    assert set(result) == set(BeamResult.__dataclass_fields__)
    assert result["tets"] == 810
    assert result["steps"] == STEPS
    assert result["step_ratio"] == 1.0
    assert result["iterations"] >= 1.0
    assert result["unconverged_steps"] == 0
    assert 0.0 < result["residual"] < residual_bound(precision)
    assert result["sag"] == pytest.approx(0.21750, rel=0.005)


def test_peers_run_beside_ours(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("mujoco")
    pytest.importorskip("pypardiso")
    ours, flex, capped, pardiso = run(capsys, "--peers", "--precision", "float64")
    assert ours["solver"] == "warp_softbody float64"
    assert (flex["solver"], capped["solver"]) == ("mujoco", "mujoco 100 iterations")
    assert flex["unconverged_steps"] == 0
    assert flex["residual"] is None
    # a solve that stopped short says so and how far it came
    assert (capped["residual"] is None) == (capped["unconverged_steps"] == 0)
    # static solution of St. Venant-Kirchhoff four-node tets on this mesh
    assert flex["sag"] == pytest.approx(0.21536, rel=0.005)
    assert pardiso["solver"] == "pypardiso"
    # a Cholesky solve is off by at most n u | |A| |v+| |; that norm is below 1000 |b| here, n = 720
    assert pardiso["residual"] < 720 * 1000 * 1.1e-16
    # the same equations brought to rest; SETTLED leaves 1e-5 of the sag to either
    assert pardiso["sag"] == pytest.approx(ours["sag"], rel=2e-5)


def test_table_has_a_line_for_each_result(capsys: pytest.CaptureFixture[str]) -> None:
    beam.main(["--tets", "810", "--steps", "1"])
    header, line = capsys.readouterr().out.splitlines()
    assert "step ms" in header
    assert line.split()[0] == "810"


@pytest.mark.parametrize("sizes", ["811", "810,ten", "", "-810"])
def test_unknown_size_is_refused(sizes: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ending:
        beam.main([f"--tets={sizes}"])
    assert ending.value.code != 0
    assert f"{sizes.split(',')[-1]!r} tets" in capsys.readouterr().err


def test_no_steps_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        beam.main(["--steps", "0"])
    assert "above 0" in capsys.readouterr().err


NEW_MUJOCO = SimpleNamespace(mjtIntegrator=SimpleNamespace(mjINT_DISCRETE=4))
OLD_MUJOCO = SimpleNamespace(mjtIntegrator=SimpleNamespace(), __version__="3.2.0")


@pytest.mark.parametrize(
    ("mujoco", "sentence"),
    [
        (None, "--peers needs the package mujoco; "),
        (NEW_MUJOCO, "--peers needs the package pypardiso; "),
        (OLD_MUJOCO, "--peers needs MuJoCo 3.13 or later, not 3.2.0; "),
    ],
)
def test_missing_peer_is_named_before_anything_runs(
    mujoco: Any,
    sentence: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", mujoco)
    monkeypatch.setitem(sys.modules, "pypardiso", None)
    monkeypatch.setattr(beam, "warp_engine", lambda *_, **__: pytest.fail("something ran"))
    with pytest.raises(SystemExit) as ending:
        beam.main(["--peers"])
    assert ending.value.code != 0
    said = capsys.readouterr()
    assert said.out == ""
    assert sentence in said.err
    assert "warp-softbody[bench]" in said.err


class Falling:
    """A solver that only falls, one metre a step, and writes its name down."""

    def __init__(self, name: str, log: list[str]) -> None:
        """Begin at rest."""
        self._name, self._log, self._fallen = name, log, 0.0

    def step(self) -> StepReport:
        """Fall."""
        self._log.append(self._name)
        self._fallen += 1.0
        return StepReport()

    def assembly_ms(self) -> None:
        """None."""
        return None

    def positions(self) -> FloatArray:
        """The straight beam, lower."""
        return np.asarray(cantilever(810).mesh.points - np.array([0.0, 0.0, self._fallen]))

    def state(self) -> None:
        """None."""
        return None


def test_solvers_take_turns() -> None:
    log: list[str] = []
    entrants = [Entrant(Falling(name, log), setup_ms=0.0) for name in "ab"]
    run_in_turn(entrants, 7, CorotationalSystem(cantilever(810), TIME_STEP), lambda done: None)
    assert "".join(log) == "aaaaabbbbbaabb"
    assert [len(entrant.step_ms) for entrant in entrants] == [7, 7]


def test_a_beam_that_never_rests_has_no_sag() -> None:
    # 1 / k is above SETTLED in each of the steps k that it is given
    assert static_sag(lambda body, time_step: Falling("a", []), cantilever(810)) is None
