"""The problem that native code makes out of a step's maps against ``build_qpcc``."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from warp_softbody.controllers.compiled.contact_solver import GIVEN, CompiledSearch, sizes_of
from warp_softbody.controllers.controller import ActivationCost, Goals
from warp_softbody.controllers.objectives import Objective
from warp_softbody.controllers.patches import Patch
from warp_softbody.controllers.qpcc.result import SolverOptions
from warp_softbody.controllers.qpcc.solve import solve_qpcc
from warp_softbody.controllers.step_problem import build_qpcc, step_terms
from warp_softbody.engine.native_maps import StepMaps
from warp_softbody.kernels.control.contact_search import LIMITS

DT = 0.01
ROWS = (2, 3)
SEGMENTS = 30


def step(contacts: int, seed: int = 0) -> tuple[Goals, StepMaps, Any]:
    """Goals and maps of no body, and activations to begin with."""
    rng = np.random.default_rng(seed)
    count = sum(ROWS) + 3 * contacts
    factor = rng.standard_normal((count, count + 4))
    wanted = tuple(
        Objective(
            name=f"goal {k}",
            rows=np.ones((k, 6)),
            target=rng.standard_normal(k),
            weight=rng.uniform(0.0, 2.0, k),
        )
        for k in ROWS
    )
    patches = tuple(
        Patch(
            weights=np.ones(2),
            gap=float(gap),
            frame=np.eye(3),
            friction=0.7,
            touching=bool(k % 2),
            factors=rng.uniform(0.5, 2.0, 8),
            slips=k == 1,
        )
        for k, gap in enumerate(rng.uniform(0.0, 1e-3, contacts))
    )
    cost = ActivationCost(effort=0.3, change=0.2)
    goals = Goals(objectives=wanted, patches=patches, activation=cost, resting=(3, 5))
    lengths = rng.uniform(0.1, 0.2, SEGMENTS)
    velocity = rng.standard_normal(count)
    # contacts can all be left, as the search needs a point to begin with
    velocity[sum(ROWS) :: 3] = 2.0
    maps = StepMaps(
        compliance=factor @ factor.T,
        free_velocity=velocity,
        muscle_map=rng.standard_normal((count, SEGMENTS)),
        lengths=lengths,
        reaches=lengths * rng.uniform(0.3, 1.1, SEGMENTS),
        rest_lengths=rng.uniform(0.15, 0.2, SEGMENTS),
        iterations=1,
        converged=True,
    )
    return goals, maps, rng.uniform(0.5, 1.0, SEGMENTS)


@pytest.mark.parametrize("cone", [4, 8])
@pytest.mark.parametrize("contacts", [0, 3])
def test_arrays_and_result_are_those_of_the_built_problem(contacts: int, cone: int) -> None:
    search = CompiledSearch()
    for seed in range(4):
        goals, maps, before = step(contacts, seed)
        asked = (goals, maps, before, DT)
        problem = build_qpcc(*asked, time_unit=0.3, cone=cone)
        known: dict[str, Any] = {
            "start": (0,) * contacts,
            "touching": np.array([patch.touching for patch in goals.patches], dtype=bool),
            "options": SolverOptions(),
        }
        found = search.solve_step(step_terms(*asked, time_unit=0.3, cone=cone), **known)
        room = search.rooms.of(sizes_of(problem)).numbers
        expected = {name: getattr(problem, name) for name in GIVEN}
        expected |= {
            "offset": problem.velocity_offset,
            "by_controls": problem.velocity_from_controls,
            "by_forces": problem.velocity_from_forces,
        }
        for name, values in expected.items():
            bound = 1e-12 * np.abs(values).max(initial=1e-9)
            if name == "diagonal":
                # NumPy has it as a difference from the whole Hessian
                bound = 1e-12 * problem.hessian.max()
            np.testing.assert_allclose(room[name], values, rtol=0.0, atol=bound, err_msg=name)
        assert room["scalars"][0] == pytest.approx(problem.constant, rel=1e-12)
        assert found is not None
        other = solve_qpcc(problem, fallback_controls=before, **known)
        assert found.objective <= other.objective * (1.0 + 1e-7)
        assert problem.objective(found.controls, found.forces) == pytest.approx(
            found.objective, rel=1e-7
        )


def test_what_cannot_be_a_problem_is_left() -> None:
    """Numbers that are not finite, factors that are none, and a diagonal lost in rounding."""
    search = CompiledSearch()
    goals, maps, before = step(2)
    known: dict[str, Any] = {"start": (0, 0), "touching": np.ones(2, bool)}
    good = step_terms(goals, maps, before, DT, time_unit=0.3)
    spoilt = [
        good._replace(muscle_map=np.full_like(good.muscle_map, np.nan)),
        good._replace(step_velocity=np.full_like(good.step_velocity, np.inf)),
        good._replace(factors=np.zeros_like(good.factors)),
        good._replace(costs=(1e-14, 0.0)),
        good._replace(targets=np.zeros(0), goal_weights=np.zeros(0)),
    ]
    for numbers in spoilt:
        assert search.solve_step(numbers, options=SolverOptions(), **known) is None
    assert search.solve_step(good, options=SolverOptions(), **known) is not None
    cold: dict[str, Any] = {"start": None, "touching": np.ones(2, bool)}
    assert search.solve_step(good, options=SolverOptions(starts=2), **cold) is None


def test_segments_rest_only_while_they_are_told_to() -> None:
    search = CompiledSearch()
    goals, maps, before = step(1)
    known: dict[str, Any] = {
        "start": (0,),
        "touching": np.ones(1, bool),
        "options": SolverOptions(),
    }
    for resting in ((3, 5), (), (7,)):
        own = replace(goals, resting=resting)
        numbers = step_terms(own, maps, before, DT, time_unit=0.3)
        assert search.solve_step(numbers, **known) is not None
        room = search.rooms.of((SEGMENTS, 1, 8, sum(ROWS))).numbers
        held = np.flatnonzero(room["lower"] == room["upper"])
        assert set(resting) <= set(held.tolist())
        expected = build_qpcc(own, maps, before, DT, time_unit=0.3)
        np.testing.assert_array_equal(room["lower"], expected.lower)


def test_limits_are_those_of_the_numpy_form() -> None:
    from warp_softbody.controllers.qpcc.contact.objective import ROUNDING
    from warp_softbody.controllers.step_problem import SHORTEST

    assert float(LIMITS["SHORTEST"]) == SHORTEST
    assert float(LIMITS["CLEAR"]) == ROUNDING
