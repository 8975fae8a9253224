"""What preconditioners give on the matrix of the benchmark beam in mid swing.

The cantilever of ``benchmarks.beam`` falls from the straight shape for 25 steps of 0.01 s, stepped
by the engine. The linear system of the next step is assembled by NumPy in double precision and
solved by conjugate gradients from the present velocities to a relative residual of 1e-5, once with
each preconditioner. Clamped nodes are left out. docs/preconditioners.md says what the engine chose.

Work is counted, not timed: the unit is one product of the matrix with a vector, that is one
multiplication of a 3 x 3 block and a vector for each block of the matrix; two blocks multiplied by
each other count as three. What vectors cost by themselves is not counted, nor that diagonals run
on many threads at once where sweeps and factors go node by node.

--json prints a list of objects, one a size and preconditioner:
  tets, nodes         of the mesh, and its nodes that are not clamped
  preconditioner      by name
  iterations          of conjugate gradients
  work_per_iteration  1 for conjugate gradients, and the blocks that the preconditioner touches
  work                iterations times work_per_iteration
  renewal             work that every step's new matrix asks for before the first iteration
  memory              blocks kept besides the matrix, over the blocks of the matrix
  setup_s             of SciPy and NumPy, s, all that is done once or at every step; tells little
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial

from benchmarks.beam.arguments import progress, sizes
from benchmarks.beam.cantilever import cantilever
from benchmarks.preconditioners import one_level, two_level
from benchmarks.preconditioners.one_level import CandidatePreconditioner
from benchmarks.preconditioners.system import (
    StepSystem,
    conjugate_gradients,
    mid_swing,
    step_system,
)
from benchmarks.tables import as_text
from warp_softbody.run.warp_session import warp_engine

OURS = "Gauss-Seidel, coarse"

PRECONDITIONERS: dict[str, Callable[[StepSystem], CandidatePreconditioner]] = {
    "none": one_level.identity,
    "point Jacobi": one_level.point_jacobi,
    "block Jacobi": one_level.block_jacobi,
    "Gauss-Seidel": one_level.gauss_seidel,
    "incomplete factor": one_level.incomplete_factor,
    "block Jacobi + coarse": two_level.additive,
    "Jacobi, coarse": two_level.between_jacobi,
    OURS: two_level.between_gauss_seidel,
    "same, present coarse": partial(two_level.between_gauss_seidel, present=True),
    "same, smoothed coarse": partial(two_level.between_gauss_seidel, smoothed=True),
    "factor of rest, turned": one_level.rest_factor,
    "factor": one_level.present_factor,
}
"""By name; those named ``same`` differ from ours in their coarse space alone."""


@dataclass(frozen=True, kw_only=True)
class PreconditionerResult:
    """One preconditioner at one size; the command's description says what each number means."""

    tets: int
    nodes: int
    preconditioner: str
    iterations: int
    work_per_iteration: float
    work: float
    renewal: float
    memory: float
    setup_s: float


COLUMNS = {
    "iterations": ("iterations", "d"),
    "work each": ("work_per_iteration", ".2f"),
    "work": ("work", ".0f"),
    "renewal": ("renewal", ".1f"),
    "memory": ("memory", ".2f"),
    "set-up s": ("setup_s", ".2f"),
}


def examine(tets: int, system: StepSystem, name: str) -> PreconditionerResult:
    """Build a preconditioner, solve with it and count."""
    begun = time.perf_counter()
    built = PRECONDITIONERS[name](system)
    setup = time.perf_counter() - begun
    _, iterations = conjugate_gradients(system, built.apply)
    each = 1.0 + built.touched / system.blocks
    return PreconditionerResult(
        tets=tets,
        nodes=system.nodes,
        preconditioner=name,
        iterations=iterations,
        work_per_iteration=each,
        work=iterations * each,
        renewal=built.renewed / system.blocks,
        memory=built.stored / system.blocks,
        setup_s=setup,
    )


def examine_all(tets: int) -> list[PreconditionerResult]:
    """Every preconditioner on the beam of one size."""
    beam = cantilever(tets)
    progress(f"{tets} tets: falling")
    system = step_system(beam, *mid_swing(beam))
    results = []
    for name in PRECONDITIONERS:
        progress(f"{tets} tets: {name}")
        results.append(examine(tets, system, name))
    progress("")
    return results


def table(results: list[PreconditionerResult]) -> str:
    """Lines of a table."""
    return as_text(
        ("tets", "preconditioner", *COLUMNS),
        ((result.tets, result.preconditioner, *_cells(result)) for result in results),
        left="preconditioner",
    )


def _cells(result: PreconditionerResult) -> list[str]:
    return [format(getattr(result, name), form) for name, form in COLUMNS.values()]


def main(arguments: list[str] | None = None) -> None:
    """Print a table, or JSON."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.preconditioners",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--tets", type=sizes, default="810,10290", help="out of 810,10290,51840")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    results: list[PreconditionerResult] = []
    with warp_engine("cpu", on_compile=lambda: None):
        for size in options.tets:
            results += examine_all(size)
    if options.json:
        print(json.dumps([asdict(result) for result in results]))
    else:
        print(table(results))
