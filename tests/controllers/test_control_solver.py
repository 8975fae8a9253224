"""From goals to activations: the QPCC that is built, the loop that is closed."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from tests.support.bodies import EXACT, Rig, exact_dynamics, muscular_bar, numbers, rig
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.controllers import objectives
from warp_softbody.controllers.control_options import Method
from warp_softbody.controllers.control_solver import ControlSolver
from warp_softbody.controllers.controller import ActivationCost, Goals
from warp_softbody.controllers.patches import ground_patches
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC
from warp_softbody.controllers.qpcc.result import QPCCStatus
from warp_softbody.controllers.step_problem import SHORTEST, activation_bounds, build_qpcc
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.engine.reduced_dynamics import Bridge
from warp_softbody.errors import InputError
from warp_softbody.run.simulation import Simulation
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene
from warp_softbody.world.view import BodyView

DT = 0.01
LOOSE = ActivationCost(effort=1e-6, change=3e-5)
QUARTERS = tuple(f"quarter_{index}" for index in range(4))


def bar(height: float = 0.0) -> Character:
    """The muscular bar with the four quarters of its base as regions."""
    plain = muscular_bar(
        Material(young_modulus=2e5, poisson_ratio=0.4, stiffness_damping=0.01),
        origin=(0.0, 0.0, height),
    )
    base = plain.region("base")
    x, y = plain.mesh.points[base, :2].T
    quarters = {}
    for index, name in enumerate(QUARTERS):
        inside = ((x >= 0.1 - 1e-9) == bool(index % 2)) & ((y >= 0.1 - 1e-9) == bool(index // 2))
        quarters[name] = base[inside]
    return Character(
        name="bar",
        mesh=plain.mesh,
        material=plain.material,
        muscles=plain.muscles,
        regions={**plain.regions, **quarters},
    )


def between(view: BodyView, high: str = "top", low: str = "base") -> FloatArray:
    """Weights of the difference of two regions' middles."""
    weights = np.zeros(view.node_count)
    for name, sign in ((high, 1.0), (low, -1.0)):
        nodes = view.scene.character.region(name)
        weights[nodes] += sign / len(nodes)
    return weights


class Shrink:
    """Wants the top a given way above the base, at a bounded speed."""

    def __init__(self, goal: tuple[float, float, float], patches: tuple[str, ...] = ()) -> None:
        """Goal in m, from the middle of the base to the middle of the top."""
        self.goal = np.array(goal)
        self.patches = patches

    def goals(self, view: BodyView) -> Goals:
        """The velocity of the top against the base."""
        weights = between(view)
        miss = self.goal - weights @ view.positions
        wanted = objectives.velocity(view, weights, 5.0 * miss, [0.2, 0.0, 1.0])
        return Goals(
            objectives=(wanted,), patches=ground_patches(view, self.patches), activation=LOOSE
        )


class Standing:
    """Lets the body come to stand before it wants anything: what touches is then known."""

    def __init__(self, then: Shrink) -> None:
        """After 0.2 s."""
        self.then = then

    def goals(self, view: BodyView) -> Goals | None:
        """None at first."""
        return None if view.time < 0.2 - 0.5 * DT else self.then.goals(view)


def view_of(body: Rig, activations: FloatArray | None = None) -> BodyView:
    return BodyView(
        scene=body.model.scene,
        time=0.0,
        time_step=body.model.options.time_step,
        masses=body.masses,
        positions=body.positions,
        velocities=body.velocities,
        touching=np.zeros(body.model.node_count, dtype=bool),
        activations=np.ones(body.model.segment_count) if activations is None else activations,
    )


def moving_bar(ground: Plane | None = None, **options: Any) -> Rig:
    """A stretched bar in motion, assembled."""
    character = bar(height=0.02)
    body = rig(
        character, ground=ground, gravity=(0.0, 0.0, -9.81), time_step=DT, **(EXACT | options)
    )
    rng = np.random.default_rng(6)
    points = character.mesh.points * np.array([1.0, 1.0, 1.05])
    body.place(points, 0.3 * rng.standard_normal(points.shape))
    body.stepper.assemble(body.state)
    return body


def test_built_objective_is_the_weighted_squares_plus_the_costs() -> None:
    """At random activations and impulses, with contacts; J v+ as predicted."""
    body = moving_bar(ground=Plane())
    rng = np.random.default_rng(3)
    before = rng.uniform(0.6, 1.0, body.model.segment_count)
    view = view_of(body, before)
    wanted = (
        objectives.velocity(view, between(view), np.array([0.1, 0.2, -0.5]), [1.0, 2.0, 3.0]),
        objectives.linear_momentum(view, np.array([1.0, 2.0, 3.0]), 0.7),
    )
    cost = ActivationCost(effort=0.3, change=0.2)
    goals = Goals(objectives=wanted, patches=ground_patches(view, QUARTERS), activation=cost)
    rows = np.concatenate([o.rows for o in wanted] + [p.rows() for p in goals.patches])
    problem = exact_dynamics(body, row_capacity=32).solve(rows)
    qpcc = build_qpcc(goals, problem, before, DT, time_unit=0.1)
    for seed in range(5):
        rng = np.random.default_rng(seed)
        a = rng.uniform(0.5, 1.0, len(before))
        f = rng.uniform(0.0, 0.1, (4, 3))
        reached = problem.free_velocity + problem.muscle_map @ (
            a * problem.rest_lengths - problem.lengths
        )
        reached += problem.compliance[:, 6:] @ f.ravel()
        target = np.concatenate([o.target for o in wanted])
        weight = np.concatenate([o.weight for o in wanted])
        expected = float(weight @ (reached[:6] - target) ** 2)
        expected += 0.3 * float(((a - 1.0) ** 2).mean())
        expected += 2.0 * float(((a - before) ** 2).mean())  # 0.2 time units over a tenth of one
        assert qpcc.objective(a, f) == pytest.approx(expected, rel=1e-9)
        gaps = np.zeros((4, 3))
        gaps[:, 0] = [patch.gap / DT for patch in goals.patches]
        np.testing.assert_allclose(
            qpcc.velocity(a, f), reached[6:].reshape(4, 3) + gaps, rtol=1e-9, atol=1e-12
        )


def test_built_contacts_have_the_patches_friction() -> None:
    """Coefficient and factors by direction, in the patches' order; none where a patch slips."""
    body = moving_bar(ground=Plane(friction=0.3))
    view = view_of(body)
    rng = np.random.default_rng(0)
    patches = tuple(
        replace(patch, factors=rng.uniform(1.0, 10.0, 8), slips=slips)
        for patch, slips in zip(ground_patches(view, QUARTERS[:2]), (False, True), strict=True)
    )
    goals = Goals(objectives=(), patches=patches, activation=LOOSE)
    rows = np.concatenate([patch.rows() for patch in patches])
    problem = exact_dynamics(body, row_capacity=32).solve(rows)
    qpcc = build_qpcc(goals, problem, view.activations, DT, time_unit=0.1)
    np.testing.assert_array_equal(qpcc.factors, [patch.factors for patch in patches])
    np.testing.assert_array_equal(qpcc.friction, [0.3, 0.0])


@pytest.mark.parametrize("regions", [(), QUARTERS])
def test_a_step_s_problem_passes_the_checks_that_it_is_spared(regions: tuple[str, ...]) -> None:
    """It is what the constructor makes, read-only; what overflows or is no factor is named."""
    body = moving_bar(ground=Plane())
    view = view_of(body)
    wanted = objectives.velocity(view, between(view), np.array([0.1, 0.2, -0.5]))
    patches = ground_patches(view, regions)
    goals = Goals(objectives=(wanted,), patches=patches, activation=LOOSE)
    rows = np.concatenate([wanted.rows, *(patch.rows() for patch in patches)])
    problem = Bridge(body.stepper, row_capacity=32).solve(rows)
    qpcc = build_qpcc(goals, problem, view.activations, DT, time_unit=0.1)
    held = {entry.name: getattr(qpcc, entry.name) for entry in fields(ContactQPCC)}
    assert ContactQPCC(**held) == qpcc
    assert not any(value.flags.writeable for value in held.values() if np.ndim(value))
    with np.errstate(all="ignore"), pytest.raises(InputError, match="finite"):
        endless = replace(problem, muscle_map=np.full_like(problem.muscle_map, 1e200))
        build_qpcc(goals, endless, view.activations, DT, time_unit=0.1)
    if patches:
        none = replace(patches[0], factors=np.zeros(8))
        with pytest.raises(InputError, match="factors must be positive"):
            spoilt = replace(goals, patches=(none, *patches[1:]))
            build_qpcc(spoilt, problem, view.activations, DT, time_unit=0.1)


def test_decision_in_flight_is_the_bounded_least_squares_answer() -> None:
    """Without contact the QPCC is a box-constrained least-squares problem: SciPy solves it too."""
    body = moving_bar()
    view = view_of(body)
    controller = Shrink((0.0, 0.0, 0.5))
    solver = ControlSolver(controller, exact_dynamics(body))
    goals = controller.goals(view)
    decision = solver.decide(view, goals)
    objective = goals.objectives[0]
    problem = exact_dynamics(body).solve(objective.rows)
    count = body.model.segment_count
    scale = np.sqrt(objective.weight)
    by_activation = problem.muscle_map * problem.rest_lengths
    offset = problem.free_velocity - problem.muscle_map @ problem.lengths
    effort, change = np.sqrt(LOOSE.effort / count), np.sqrt(LOOSE.change / count)
    matrix = np.concatenate(
        [scale[:, None] * by_activation, effort * np.eye(count), change * np.eye(count)]
    )
    start = np.minimum(view.activations, problem.lengths / problem.rest_lengths)
    right = np.concatenate(
        [scale * (objective.target - offset), np.full(count, effort), change * start]
    )
    bounds = activation_bounds(problem)
    expected = lsq_linear(matrix, right, bounds=bounds, tol=1e-14).x
    found = decision.rest_lengths / problem.rest_lengths
    np.testing.assert_allclose(found, expected, atol=1e-6)
    assert (found >= bounds[0] - 1e-9).all() and (found <= bounds[1] + 1e-9).all()


def test_predicted_velocity_is_the_step_s() -> None:
    """What the decision promises in flight is what the step then does."""
    body = moving_bar()
    view = view_of(body)
    controller = Shrink((0.0, 0.0, 0.5))
    decision = ControlSolver(controller, exact_dynamics(body)).decide(view, controller.goals(view))
    weights = between(view)
    rows = objectives.mean_rows(view, weights)
    problem = exact_dynamics(body).solve(rows, free=True)
    promised = problem.free_velocity + problem.muscle_map @ (
        decision.rest_lengths - problem.lengths
    )
    body.stepper.step(
        *(body.state, body.control, body.contacts, body.after),
        decide=lambda: body.control.rest_lengths.assign(decision.rest_lengths),
    )
    found = weights @ numbers(body.after.velocities)
    np.testing.assert_allclose(found, promised, atol=1e-9)


@pytest.mark.parametrize("method", ["qpcc", "static"])
def test_closed_loop_in_flight_reaches_its_goal(method: Method) -> None:
    """The top leans and comes nearer to the base; every activation stays within its bounds.

    The bar can bend but not turn, since nothing gives it angular momentum.
    """
    character = bar()
    scene = Scene(character=character, gravity=(0.0, 0.0, 0.0))
    goal = (0.01, 0.0, 0.55)
    simulation = Simulation(scene, Shrink(goal), time_step=DT, fps=100.0, method=method)
    misses = []
    for frame in simulation.run(1.0):
        top = frame.positions[character.region("top")].mean(axis=0)
        way = top - frame.positions[character.region("base")].mean(axis=0)
        # the fibres lie in the plane y = 0.1 m: they have no say in y
        misses.append(np.linalg.norm((way - goal)[[0, 2]]))
        assert (frame.activations >= SHORTEST - 1e-6).all()
        assert (frame.activations <= 1.0 + 1e-6).all()
    # in 1 s at 5 1/s all but exp(-5) of the way, were it not for segments at their bound
    assert misses[-1] < 0.15 * misses[0]
    momentum = simulation.model.masses @ frame.velocities
    assert np.abs(momentum).max() < 1e-3 * simulation.model.masses.sum()


@pytest.mark.parametrize("method", ["qpcc", "static"])
def test_closed_loop_on_the_ground_reaches_its_goal(method: Method) -> None:
    character = bar()
    scene = Scene(character=character, ground=Plane(friction=0.8))
    controller = Standing(Shrink((0.0, 0.0, 0.55), patches=QUARTERS))
    simulation = Simulation(scene, controller, time_step=DT, fps=100.0, method=method)
    frames = list(simulation.run(1.2))
    heights = [np.ptp(frame.positions[:, 2]) for frame in frames]
    # three quarters of the way down; sagging under its weight alone it would stay above 0.59
    assert heights[-1] < 0.5625
    assert all(frame.positions[:, 2].min() > -1e-3 for frame in frames)
    summary = simulation.summary()
    assert summary.patches == 4
    assert summary.qps_per_step.mean >= 1.0
    assert summary.status == "complete"


def test_controller_that_wants_nothing_leaves_the_muscles_slack() -> None:
    class Idle:
        def goals(self, view: BodyView) -> Goals | None:
            return None

    scene = Scene(character=bar(), ground=Plane())
    # by default only passive steps stop their linear solve at the step's own error
    options = SimulationOptions(time_step=DT, tolerance=1e-5)
    idle = Simulation(scene, Idle(), options=options, fps=100.0)
    passive = Simulation(scene, None, options=options, fps=100.0)
    for _ in range(20):
        idle.step()
        passive.step()
    first, second = (next(s.run(s.time)) for s in (idle, passive))
    np.testing.assert_array_equal(first.positions, second.positions)
    np.testing.assert_array_equal(first.activations, 1.0)


def test_decision_s_status_is_known() -> None:
    body = moving_bar(ground=Plane())
    controller, view = Shrink((0.0, 0.0, 0.5), QUARTERS), view_of(body)
    solver = ControlSolver(controller, exact_dynamics(body, row_capacity=16))
    decision = solver.decide(view, controller.goals(view))
    assert decision.result.status in {QPCCStatus.STRONGLY_STATIONARY, QPCCStatus.NO_IMPROVING_FLIP}
    assert decision.result.complementarity < 1e-6
    assert len(decision.result.modes) == 4


def test_patches_follow_what_bears_the_load() -> None:
    """A patch that bears little has the gap of its lowest node; weights sum to one."""
    body = moving_bar(ground=Plane(offset=-0.1, friction=0.3))
    view = view_of(body)
    nodes = view.scene.character.region(QUARTERS[2])
    gaps = view.positions[nodes, 2] + 0.1
    patch = ground_patches(view, QUARTERS)[2]
    assert patch.gap == pytest.approx(gaps.min())
    assert patch.friction == 0.3 and not patch.touching
    impulses = np.zeros((view.node_count, 3))
    # far more than the body weighs
    impulses[nodes[:2], 2] = 1e9, 3e9
    view.touching[nodes[:2]] = True
    loaded = replace(view, impulses=impulses)
    patch = ground_patches(loaded, QUARTERS)[2]
    assert patch.touching
    assert patch.gap == pytest.approx(gaps[:2] @ [0.25, 0.75])
    assert patch.weights.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(patch.weights[nodes[:2]], [0.25, 0.75], atol=1e-6)
    velocity = patch.rows() @ view.velocities.ravel()
    mean = patch.weights @ view.velocities
    np.testing.assert_allclose(velocity, patch.frame @ mean, rtol=1e-12)
    np.testing.assert_allclose(patch.frame @ patch.frame.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(patch.frame) == pytest.approx(1.0)


def test_patch_of_an_unknown_region_is_refused() -> None:
    view = view_of(moving_bar(ground=Plane()))
    with pytest.raises(InputError, match="no region 'heel'"):
        ground_patches(view, ("heel",))
    flying = view_of(moving_bar())
    assert ground_patches(flying, QUARTERS) == ()
