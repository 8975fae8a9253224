"""The comparison of preconditioners: it counts right, and its counts are in the order claimed."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.linalg import eigh

from benchmarks.beam.cantilever import TIME_STEP, cantilever
from benchmarks.beam.ours import OurBeam
from benchmarks.preconditioners import command as preconditioners
from benchmarks.preconditioners.command import OURS, PRECONDITIONERS, PreconditionerResult, examine
from benchmarks.preconditioners.factors import factorise, incomplete_ldl
from benchmarks.preconditioners.system import (
    SWING_STEPS,
    TOLERANCE,
    StepSystem,
    blocks_of,
    conjugate_gradients,
    mid_swing,
    step_system,
)
from benchmarks.preconditioners.two_level import (
    between_gauss_seidel,
    coarse_space,
    regularised,
    rigid_motions,
)
from tests.support.bodies import rig
from warp_softbody import SimulationOptions
from warp_softbody.accuracy.runs.peers.beam import MATERIAL
from warp_softbody.arrays import FloatArray
from warp_softbody.engine.options import Precision
from warp_softbody.linear.block_sparsity import Pattern
from warp_softbody.linear.symbolic_ldlt import build_elimination

NAMES = list(PRECONDITIONERS)
COARSE = [name for name in NAMES if "coarse" in name]
EXAMINED = ["block Jacobi", *COARSE]


@pytest.fixture(scope="module")
def system() -> StepSystem:
    return step_system(cantilever(810), *mid_swing(cantilever(810)))


@pytest.fixture(scope="module")
def results(system: StepSystem) -> dict[str, PreconditionerResult]:
    return {name: examine(810, system, name) for name in NAMES}


@pytest.fixture(scope="module")
def condition(system: StepSystem) -> float:
    return float(np.linalg.cond(system.matrix.toarray()))


@pytest.fixture(scope="module")
def spectra(system: StepSystem) -> dict[str, FloatArray]:
    """Eigenvalues of preconditioned matrices, from P on every unit vector."""
    matrix = system.matrix.toarray()
    lower = np.linalg.cholesky(matrix)
    found = {}
    for name in EXAMINED:
        precondition = PRECONDITIONERS[name](system).apply
        inverse = np.stack([precondition(unit) for unit in np.eye(len(matrix))], axis=1)
        found[name] = eigh(lower.T @ (inverse + inverse.T) @ lower / 2.0, eigvals_only=True)
    return found


def test_objects_are_printed_for_each_preconditioner(capsys: pytest.CaptureFixture[str]) -> None:
    preconditioners.main(["--tets", "810", "--json"])
    objects = json.loads(capsys.readouterr().out)
    assert [found["preconditioner"] for found in objects] == NAMES
    for found in objects:
        assert set(found) == set(PreconditionerResult.__dataclass_fields__)
        assert found["work"] == found["iterations"] * found["work_per_iteration"]


def test_table_has_a_line_for_each_result(results: dict[str, PreconditionerResult]) -> None:
    _, *lines = preconditioners.table(list(results.values())).splitlines()
    assert all(name in line for name, line in zip(NAMES, lines, strict=True))


@pytest.mark.parametrize("sizes", ["811", "810,ten", "", "-810"])
def test_unknown_size_is_refused(sizes: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ending:
        preconditioners.main([f"--tets={sizes}"])
    assert ending.value.code != 0
    assert f"{sizes.split(',')[-1]!r} tets" in capsys.readouterr().err


@pytest.mark.parametrize("name", NAMES)
def test_conjugate_gradients_reach_the_solution(system: StepSystem, name: str) -> None:
    found, _ = conjugate_gradients(system, PRECONDITIONERS[name](system).apply)
    residual = np.linalg.norm(system.right - system.matrix @ found)
    # it is carried along and drifts by 10 roundings of |A| |v+| < 1000 |b| in each iteration
    drift = 10 * 1000 * 200 * 1.1e-16
    assert residual <= (TOLERANCE + drift) * np.linalg.norm(system.right)


@pytest.mark.parametrize("name", NAMES)
def test_preconditioners_are_symmetric(system: StepSystem, condition: float, name: str) -> None:
    precondition = PRECONDITIONERS[name](system).apply
    a, b = system.right, system.right - system.matrix @ system.start
    applied = precondition(b)
    # a whole factor may be off by its condition number in roundings, and sweeps are off by less
    bound = 8.0 * condition * 2.2e-16 * np.linalg.norm(a) * np.linalg.norm(applied)
    assert abs(a @ applied - b @ precondition(a)) <= bound


@pytest.mark.parametrize("name", EXAMINED)
def test_iterations_are_within_the_bound_of_the_condition_number(
    system: StepSystem,
    condition: float,
    results: dict[str, PreconditionerResult],
    spectra: dict[str, FloatArray],
    name: str,
) -> None:
    """Iterations k leave at most 2 q^k of the error's A-norm, q = (root - 1) / (root + 1)."""
    values = spectra[name]
    root = math.sqrt(values[-1] / values[0])
    first = float(np.linalg.norm(system.right - system.matrix @ system.start))
    # from residuals to A-norms of errors and back costs at most the root of A's condition number
    spread = 2.0 * math.sqrt(condition)
    ratio = TOLERANCE * float(np.linalg.norm(system.right)) / first / spread
    most = math.ceil(math.log(ratio, (root - 1.0) / (root + 1.0)))
    assert 1 <= results[name].iterations <= most


def test_counts_stand_in_the_order_that_the_page_claims(
    results: dict[str, PreconditionerResult],
) -> None:
    counts = {name: results[name].iterations for name in NAMES}
    one_level = ["none", "point Jacobi", "block Jacobi", "Gauss-Seidel", "incomplete factor"]
    assert np.all(np.diff([counts[name] for name in one_level]) < 0)
    two_levels = ["block Jacobi + coarse", "Jacobi, coarse", OURS, "same, smoothed coarse"]
    assert np.all(np.diff([counts[name] for name in two_levels]) < 0)
    assert max(counts[name] for name in COARSE) <= counts["block Jacobi"] / 3
    assert counts["factor of rest, turned"] < counts[OURS]
    assert counts["factor"] == 1
    assert counts[OURS] <= counts["same, present coarse"] + 1


def test_work_stands_in_the_order_that_the_page_claims(
    results: dict[str, PreconditionerResult],
) -> None:
    total = {name: results[name].work + results[name].renewal for name in NAMES}
    dearer = [*NAMES[: NAMES.index(OURS)], "same, present coarse"]
    assert total[OURS] < min(total[name] for name in dearer)
    assert total["factor of rest, turned"] < total[OURS] < total["factor"]


def test_coarse_spaces_take_the_smallest_eigenvalues_away(spectra: dict[str, FloatArray]) -> None:
    """Iterations go with the root of the condition number: three times fewer, nine times less."""
    conditions = {name: values[-1] / values[0] for name, values in spectra.items()}
    for name in COARSE:
        assert conditions[name] <= conditions["block Jacobi"] / 9.0
    # with the present matrix sweeps and correction never amplify; 1e-9 is rounding
    assert spectra["same, present coarse"][-1] <= 1.0 + 1e-9


@pytest.mark.parametrize(
    ("tets", "precision"), [(810, "float32"), (810, "float64"), (10_290, "float32")]
)
def test_ours_is_what_the_engine_does(tets: int, precision: Precision) -> None:
    """As many iterations as the engine's own step took; rounding may move the last one."""
    beam = cantilever(tets)
    solver = OurBeam(beam, TIME_STEP, precision, preconditioner="two_level")
    for _ in range(SWING_STEPS):
        solver.step()
    state = solver.state()
    assert state is not None
    engine = solver.step().iterations
    assert engine is not None
    system = step_system(beam, *state)
    tolerance = SimulationOptions(precision=precision).solver_tolerance
    _, ours = conjugate_gradients(system, between_gauss_seidel(system).apply, tolerance)
    assert abs(ours - engine) <= 1


def test_coarse_matrix_and_its_price_are_the_engine_s(system: StepSystem) -> None:
    fixed = np.flatnonzero(system.beam.fixed)
    options: dict[str, Any] = {"time_step": TIME_STEP, "preconditioner": "two_level"}
    model = rig(system.beam.mesh, material=MATERIAL, fixed=fixed, **options).model
    level = model.system.coarse
    assert level is not None
    motions = rigid_motions(system).tocsr()
    found = blocks_of(regularised((motions.T @ system.rest @ motions).tocsr()))
    pattern = level.aggregation.pattern
    np.testing.assert_array_equal(found.indptr, pattern.row_start)
    np.testing.assert_array_equal(found.indices, pattern.column)
    # sums of at most 100 terms, each of a few roundings
    expected = level.values
    np.testing.assert_allclose(found.data, expected, rtol=0.0, atol=1e-13 * expected.max())
    price = 2 * len(model.system.elimination.column) + len(model.system.elimination.order)
    coarse = coarse_space(system).touched
    assert coarse == pytest.approx(price + 2 * (1 + 1 / 3) * system.nodes, rel=1e-12)
    # forward sweep with residual, backward sweep
    touched = between_gauss_seidel(system).touched
    assert touched == pytest.approx(2 * system.blocks + coarse, rel=1e-12)


def test_factor_is_counted_as_the_engine_counts_its_own(system: StepSystem) -> None:
    blocks = blocks_of(system.matrix)
    owner = np.repeat(np.arange(system.nodes), np.diff(blocks.indptr))
    diagonal = np.flatnonzero(owner == blocks.indices).astype(np.int32)
    pattern = Pattern(row_start=blocks.indptr, column=blocks.indices, diagonal_slot=diagonal)
    elimination = build_elimination(pattern, np.zeros(system.nodes, dtype=bool))
    factor = factorise(system.matrix)
    assert factor.below == len(elimination.column)
    # the engine's count leaves the updates of pivots out, one for each block
    assert factor.updates == elimination.update_count + len(elimination.column)


def chain(count: int) -> sp.csr_matrix:
    """Nodes in a row, each coupled to the next: a factor in this order has no fill."""
    below = np.kron(np.eye(count, k=-1), np.random.default_rng(4).uniform(-1.0, 1.0, (3, 3)))
    return sp.csr_matrix(8.0 * np.eye(3 * count) + below + below.T)


def test_incomplete_factor_is_whole_where_there_is_no_fill() -> None:
    matrix = chain(6)
    lower, pivots, updates = incomplete_ldl(matrix)
    product = (lower @ sp.block_diag(list(pivots)) @ lower.T).toarray()
    np.testing.assert_allclose(product, matrix.toarray(), rtol=0.0, atol=1e-14)
    assert updates == 5


def test_incomplete_factor_matches_the_matrix_on_its_pattern(system: StepSystem) -> None:
    """What IC(0) is: L D L^T and A agree wherever A has a block."""
    lower, pivots, _ = incomplete_ldl(system.matrix)
    product = (lower @ sp.block_diag(list(pivots)) @ lower.T).toarray()
    matrix = system.matrix.toarray()
    blocks = blocks_of(system.matrix)
    pattern = sp.csr_matrix((np.ones(len(blocks.indices)), blocks.indices, blocks.indptr))
    kept = np.kron(pattern.toarray(), np.ones((3, 3))) > 0.0
    # an entry is the sum of at most 100 products, each of a few roundings
    assert np.abs((product - matrix)[kept]).max() <= 1e-13 * np.abs(matrix).max()


def test_incomplete_factor_of_an_indefinite_matrix_is_refused() -> None:
    with pytest.raises(ArithmeticError, match="node 0 is not positive definite"):
        incomplete_ldl(-chain(3))
