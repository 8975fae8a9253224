"""A clamped beam sags under its weight: milliseconds a step, iterations and sag by mesh size.

The beam is 1 x 0.2 x 0.2 m, clamped at x = 0, E = 1e6 Pa, nu = 0.4, rho = 1000 kg/m^3, dt = 0.01 s,
on a regular grid of six tets a cell. The sag is that of the tip face after four seconds with heavy
stiffness damping; corotational four-node tets on the same meshes sag 0.21750, 0.30479 and 0.32690 m
at rest (VegaFEM).
"""

from __future__ import annotations

import argparse
import itertools
import json
import time
from dataclasses import asdict, dataclass

import numpy as np
import numpy.typing as npt

from warp_softbody import Character, Material, Scene, SimulationOptions, Stepper, TetMesh
from warp_softbody import build_model as build
from warp_softbody.cli.engine import warp_engine
from warp_softbody.state import Contacts, Control, State
from warp_softbody.stepper import StepStatistics

FloatArray = npt.NDArray[np.float64]
CELLS = {810: 3, 10_290: 7, 51_840: 12}


@dataclass(frozen=True, kw_only=True)
class Result:
    """One size; times in ms, lengths in m."""

    tets: int
    solver: str
    setup_ms: float
    step_ms: float
    step_ms_p95: float
    iterations: float
    sag: float


def beam_mesh(cells: int) -> TetMesh:
    """A grid of 5 n x n x n cells of six Kuhn tets each."""
    counts = np.array([5 * cells, cells, cells])
    axes = [
        np.linspace(0.0, size, count + 1)
        for size, count in zip((1.0, 0.2, 0.2), counts, strict=True)
    ]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    corners = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 3)
    strides = np.array([(counts[1] + 1) * (counts[2] + 1), counts[2] + 1, 1])
    tets = []
    for order in itertools.permutations(range(3)):
        path = np.cumsum([np.zeros(3, int), *np.eye(3, dtype=int)[list(order)]], axis=0)
        tets.append((corners[:, None, :] + path) @ strides)
    return TetMesh.from_arrays(points, np.concatenate(tets))


class Beam:
    """A beam with two states that are swapped."""

    def __init__(self, mesh: TetMesh, precision: str, damping: float) -> None:
        """Build the model of a beam with a stiffness damping in s."""
        material = Material(young_modulus=1e6, poisson_ratio=0.4, stiffness_damping=damping)
        fixed = np.flatnonzero(mesh.points[:, 0] < 1e-9).astype(np.int32)
        body = Character(name="beam", mesh=mesh, material=material, fixed=fixed)
        options = SimulationOptions(time_step=0.01, precision=precision)  # type: ignore[arg-type]
        self.model = build(Scene(character=body), options)
        self._stepper = Stepper(self.model)
        self._states = [State.at_rest(self.model), State.at_rest(self.model)]
        self._control, self._contacts = Control.slack(self.model), Contacts.none(self.model)

    def step(self) -> StepStatistics:
        """One step of 0.01 s."""
        now, after = self._states
        statistics = self._stepper.step(now, self._control, self._contacts, after)
        self._states.reverse()
        return statistics

    def sag(self) -> float:
        """Mean fall of the tip face, m."""
        rest = self.model.scene.character.mesh.points
        tip = rest[:, 0] > 1.0 - 1e-9
        return float((rest - self._states[0].positions.numpy())[tip, 2].mean())


def measure(tets: int, precision: str, steps: int) -> Result:
    """Time ``steps`` steps from the straight beam on, and let another one come to rest."""
    mesh = beam_mesh(CELLS[tets])
    begun = time.perf_counter()
    beam = Beam(mesh, precision, damping=0.0)
    beam.step()
    setup = time.perf_counter() - begun
    times, iterations = [], []
    for _ in range(steps):
        begun = time.perf_counter()
        iterations.append(beam.step().iterations)
        times.append(1e3 * (time.perf_counter() - begun))
    resting = Beam(mesh, precision, damping=0.2)
    for _ in range(400):
        resting.step()
    return Result(
        tets=len(mesh.tets),
        solver=f"warp_softbody {precision}",
        setup_ms=1e3 * setup,
        step_ms=float(np.median(times)),
        step_ms_p95=float(np.percentile(times, 95)),
        iterations=float(np.mean(iterations)),
        sag=resting.sag(),
    )


def main(arguments: list[str] | None = None) -> None:
    """Print a table, or JSON."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.beam", description=__doc__)
    parser.add_argument("--tets", default="810,10290", help="sizes out of 810, 10290, 51840")
    parser.add_argument("--precision", default="float32", choices=("float32", "float64"))
    parser.add_argument("--steps", type=int, default=100)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    sizes = [int(size) for size in options.tets.split(",")]
    if unknown := [size for size in sizes if size not in CELLS]:
        parser.error(f"--tets: no mesh of {unknown[0]} tets; known: {', '.join(map(str, CELLS))}")
    with warp_engine("cpu", on_compile=lambda: None):
        results = [measure(size, options.precision, options.steps) for size in sizes]
    if options.json:
        print(json.dumps([asdict(result) for result in results]))
        return
    print("   tets  setup ms  step ms     p95  iterations  sag m")
    for r in results:
        print(
            f"{r.tets:7d} {r.setup_ms:9.0f} {r.step_ms:8.2f} {r.step_ms_p95:7.2f}"
            f" {r.iterations:11.1f}  {r.sag:.5f}"
        )


if __name__ == "__main__":
    main()
