"""A clamped beam sags under its weight: ours and, on request, other programs side by side in turn.

The beam is 1 x 0.2 x 0.2 m, clamped at x = 0, E = 1e6 Pa, nu = 0.4, rho = 1000 kg/m^3, g = 9.81
m/s^2, undamped, on a regular grid of six tets a cell, stepped by dt = 0.01 s from the straight
shape. Every solver uses one thread. With --peers, ours, MuJoCo (flex, integrator `discrete`) and a
step of our equations by NumPy and Pardiso take a few steps each in turn; ratios are of medians in
this one run. MuJoCo runs twice: with our tolerance and as many iterations as that takes, and with
its default cap of 100 iterations, at which its solve may stop short. --variants times ours also
with its more accurate options, --threads N also on N threads. Where a number is not to be
had it is a dash, in JSON null.

--json prints a list of objects, one a size and solver:
  tets, solver, steps    what was timed, and how many steps
  setup_ms               model and first step, ms; compiling kernels is not counted
  step_ms                median, ms, with step_ms_p10 and step_ms_p90 for the spread
  step_ratio             step_ms over that of ours
  assembly_ms            forces and matrix alone, ms: of ours, Stepper.assemble timed apart, of
                         Pardiso, the NumPy part of a step; assembly_ns_per_tet the same by tet
  solve_ms               of Pardiso, factorise and solve, ms; solve_ratio is solve_ms over the
                         step_ms of ours, the whole step
  iterations             of conjugate gradients, mean a step; MuJoCo does not tell
  unconverged_steps      steps whose linear solve stopped before its tolerance
  residual               |b - A v+| / |b| over the nodes not clamped, recomputed in double precision
                         by NumPy from the states before and after the first, middle and last step,
                         their maximum; rounding of A and b to single precision counts as residual.
                         Of MuJoCo, whose law is another, the largest that its own warnings name,
                         relative to the right-hand side of its own solve; null: it named none
  sag                    fall of the tip face at rest, m, from steps of 0.5 s; null: it did not come
                         to rest in 60 of them, or a peer of more than 20,000 tets. Corotational
                         four-node tets on these meshes sag 0.21750, 0.30479 and 0.32690 m (VegaFEM,
                         static), St. Venant-Kirchhoff ones, as MuJoCo's, 0.21536 and 0.30433 m
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from functools import partial
from typing import Any

from benchmarks.beam.arguments import count, progress, sizes
from benchmarks.beam.cantilever import CELLS, TIME_STEP, cantilever
from benchmarks.beam.ours import OurBeam
from benchmarks.beam.rounds import enter, run_in_turn
from benchmarks.beam.solver import Make, static_sag
from benchmarks.beam.table import BeamResult, summarise, table
from warp_softbody import SimulationOptions
from warp_softbody.accuracy.runs.peers import missing_peer
from warp_softbody.accuracy.runs.peers.beam import Cantilever
from warp_softbody.accuracy.runs.peers.corotation import CorotationalSystem
from warp_softbody.accuracy.runs.peers.mujoco_flex import MujocoBeam
from warp_softbody.accuracy.runs.peers.pardiso_step import PardisoBeam
from warp_softbody.engine.options import Precision
from warp_softbody.run.warp_session import warp_engine

PEER_SAG_LIMIT = 20_000
"""Tets up to which peers are also let come to rest."""

ENOUGH_ITERATIONS = 10_000
DEFAULT_ITERATIONS = 100


VARIANTS: dict[str, dict[str, Any]] = {
    "conserving": {"tangent": "conserving"},
    "exact": {"tangent": "exact"},
    "smoothed": {"elements": "smoothed"},
    "two Newton": {"newton_iterations": 2},
}
"""Options of ours that cost time and buy accuracy."""


def solvers(
    precision: Precision, *, peers: bool = False, variants: bool = False, threads: int = 1
) -> dict[str, Make]:
    """What is timed, ours first, by name."""
    ours = partial(OurBeam, precision=precision)
    made: dict[str, Make] = {f"warp_softbody {precision}": ours}
    if threads > 1:
        made[f"ours, {threads} threads"] = partial(ours, threads=threads)
    if variants:
        made.update({f"ours, {name}": partial(ours, **more) for name, more in VARIANTS.items()})
    if peers:
        tolerance = SimulationOptions(precision=precision).solver_tolerance
        flex = partial(MujocoBeam, tolerance=tolerance)
        made["mujoco"] = partial(flex, iterations=ENOUGH_ITERATIONS)
        made["mujoco 100 iterations"] = partial(flex, iterations=DEFAULT_ITERATIONS)
        made["pypardiso"] = PardisoBeam
    return made


def measure(tets: int, makes: dict[str, Make], steps: int) -> list[BeamResult]:
    """Time all solvers on one mesh and let them come to rest."""
    beam = cantilever(tets)
    entrants = []
    for name, make in makes.items():
        progress(f"{tets} tets: setting up {name}")
        entrants.append(enter(make, beam))
    system = CorotationalSystem(beam, TIME_STEP)
    run_in_turn(entrants, steps, system, lambda done: progress(f"{tets} tets: {done} steps"))
    results = []
    for place, (name, make) in enumerate(makes.items()):
        sag = None
        if place == 0 or tets <= PEER_SAG_LIMIT:
            progress(f"{tets} tets: {name} comes to rest")
            sag = static_sag(make, beam)
        results.append(summarise(name, entrants[place], entrants[0], tets, sag))
    progress("")
    return results


def main(arguments: list[str] | None = None) -> None:
    """Print a table, or JSON."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.beam",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--tets", type=sizes, default="810,10290", help="out of 810,10290,51840")
    parser.add_argument("--precision", default="float32", choices=("float32", "float64"))
    parser.add_argument("--variants", action="store_true", help="also time ours with its options")
    parser.add_argument("--threads", type=count, default=1, help="also time ours with so many")
    parser.add_argument("--steps", type=count, default=100, help="timed steps of each solver")
    parser.add_argument("--peers", action="store_true", help="also time MuJoCo and Pardiso")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    if options.peers and (problem := missing_peer()):
        parser.error(problem)
    makes = solvers(
        options.precision,
        peers=options.peers,
        variants=options.variants,
        threads=options.threads,
    )
    results: list[BeamResult] = []
    with warp_engine("cpu", on_compile=lambda: None):
        _compile(next(iter(makes.values())), cantilever(min(CELLS)))
        for size in options.tets:
            results += measure(size, makes, options.steps)
    if options.json:
        print(json.dumps([asdict(result) for result in results]))
    else:
        print(table(results))


def _compile(make: Make, beam: Cantilever) -> None:
    """Have the kernels compiled before any clock starts."""
    progress("compiling")
    make(beam, TIME_STEP).step()
