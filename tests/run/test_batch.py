"""Batches: the bits of single runs, members of their own, failures that stay with their member."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support.bodies import box, muscular_bar
from warp_softbody import (
    Batch,
    BatchMember,
    Body,
    Character,
    Handle,
    Material,
    MotionPath,
    Plane,
    Push,
    Scene,
    Simulation,
    SimulationOptions,
    build_model,
    placed,
)
from warp_softbody.controllers import Balance, Goals, objectives
from warp_softbody.errors import InputError, NotFiniteError
from warp_softbody.world.frame import Frame
from warp_softbody.world.view import BodyView

PASSIVE = Scene(
    character=Character(name="block", mesh=box(), muscles=(), material=Material(young_modulus=1e5)),
    ground=Plane(friction=0.5, offset=-0.02),
)
BAR = Scene(character=muscular_bar(), ground=Plane(friction=0.8))
BARS = replace(
    BAR,
    others=(Body(character=placed(BAR.character, name="second", translation=(0.0, 0.0, 0.3))),),
)
SECONDS = 0.2


class Lift:
    """Wants the bar to rise; remembers how often it was asked."""

    def __init__(self, force: float) -> None:
        """Push upwards with a force, N."""
        self.force = force
        self.asked = 0

    def goals(self, view: BodyView) -> Goals:
        """A momentum that rises."""
        self.asked += 1
        rate = np.array([0.0, 0.0, self.force])
        return Goals(objectives=(objectives.linear_momentum(view, rate),))


def varied(member: BatchMember) -> BatchMember:
    """A material, a push and a friction of its own, by the member's random numbers."""
    scene, random = member.scene, member.random
    material = replace(
        scene.character.material,
        young_modulus=1e5 * random.uniform(0.5, 2.0),
        stiffness_damping=random.uniform(0.01, 0.05),
        density=random.uniform(500.0, 2000.0),
    )
    regions = {"corner": np.array([0, 1, 2])}
    character = replace(scene.character, material=material, regions=regions)
    force = tuple(random.normal(0.0, 5.0, 3).tolist())
    push = Push(region="corner", force=force, start=0.05, duration=0.1)
    ground = Plane(friction=random.uniform(0.1, 1.0), offset=-0.02)
    scene = replace(scene, character=character, pushes=(push,), ground=ground)
    return replace(member, scene=scene)


def controlled(member: BatchMember) -> BatchMember:
    """A strength and a controller of its own."""
    group = replace(member.scene.character.muscles[0], strength=1e5 * (1 + member.index))
    character = replace(member.scene.character, muscles=(group,))
    scene = replace(member.scene, character=character)
    return replace(member, scene=scene, controller=Lift(20.0 * member.index))


def both(member: BatchMember) -> BatchMember:
    """A controller for each of two bars."""
    force = 5.0 * (1 + member.index)
    return replace(member, controller=Lift(force), others={"second": Lift(-force)})


def members(scene: Scene, count: int, vary: object) -> list[BatchMember]:
    """What the batch below was made of, once more."""
    found: list[BatchMember] = []
    Batch(scene, count, lambda member: found.append(vary(member)) or found[-1])  # type: ignore[operator,func-returns-value]
    return found


def assert_same(frame: Frame | None, other: Frame) -> None:
    assert frame is not None
    for name in ("positions", "velocities", "activations"):
        np.testing.assert_array_equal(getattr(frame, name), getattr(other, name))
    np.testing.assert_array_equal(frame.contacts.forces, other.contacts.forces)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize(("scene", "vary"), [(PASSIVE, varied), (BAR, controlled), (BARS, both)])
def test_members_take_the_steps_of_single_runs(scene: Scene, vary: object, threads: int) -> None:
    batch = Batch(scene, 5, vary, threads=threads)  # type: ignore[arg-type]
    frames = list(batch.run(SECONDS))
    assert len(frames) == 7
    ends = {frame.positions.tobytes() for frame in frames[-1] if frame is not None}
    assert len(ends) == 5
    for member in members(scene, 5, vary):
        single_run = Simulation(member.scene, member.controller, others=member.others)
        alone = list(single_run.run(SECONDS))
        for together, single in zip(frames, alone, strict=True):
            assert_same(together[member.index], single)


def test_a_member_s_motion_goes_on_alone() -> None:
    batch = Batch(BAR, 2, controlled)
    for _ in range(5):
        batch.step()
    saved = batch[1].save()
    for _ in range(5):
        batch.step()
    alone = Simulation(batch[1].model.scene, Lift(0.0))
    alone.restore(saved)
    for _ in range(5):
        alone.step()
    assert_same(batch[1].frame(), alone.frame())


def test_members_share_what_is_constant() -> None:
    batch = Batch(BAR, 3, controlled)
    first, second = batch[0].model, batch[1].model
    assert second.topology is first.topology
    assert second.arrays.mesh is first.arrays.mesh
    assert second.arrays.gather is first.arrays.gather
    assert second.system.elimination is first.system.elimination
    assert second.arrays.muscles.pair_weight is first.arrays.muscles.pair_weight
    assert second.muscles.stiffness[0] == 2.0 * first.muscles.stiffness[0]


def test_a_model_takes_over_nothing_that_differs() -> None:
    options = SimulationOptions(precision="float64")
    first = build_model(PASSIVE, SimulationOptions(precision="float32"))
    other = build_model(PASSIVE, options, like=first)
    assert other.topology is first.topology
    assert other.arrays.mesh is not first.arrays.mesh
    held = replace(PASSIVE, character=replace(PASSIVE.character, fixed=np.array([0, 1])))
    assert build_model(held, options, like=other).system.elimination is not first.system.elimination
    finer = replace(PASSIVE, character=replace(PASSIVE.character, mesh=box((3, 2, 2))))
    assert build_model(finer, options, like=other).topology is not first.topology


def test_random_numbers_are_those_of_the_member_and_the_seed() -> None:
    def drawn(count: int, seed: int) -> list[float]:
        found: list[float] = []

        def vary(member: BatchMember) -> BatchMember:
            found.append(float(member.random.random()))
            return member

        Batch(PASSIVE, count, vary, seed=seed)
        return found

    assert drawn(2, 3) == drawn(4, 3)[:2]
    assert len({*drawn(3, 0), *drawn(3, 1)}) == 6


def test_one_that_fails_does_not_stop_the_others() -> None:
    batch = Batch(PASSIVE, 3, options=SimulationOptions(sleep=False))
    batch.step()
    positions = batch[1].state.positions.numpy()
    batch[1].state.positions.assign(np.full_like(positions, np.nan))
    frames = list(batch.run(0.1))
    assert frames[-1][1] is None
    assert frames[-1][0] is not None
    assert isinstance(batch.failures[1], NotFiniteError)
    assert batch.running == (0, 2)
    statuses = [summary.status for summary in batch.summaries()]
    assert statuses == ["complete", "not finite", "complete"]


def test_one_that_is_left_takes_no_more_steps() -> None:
    batch = Batch(PASSIVE, 2)
    frames: tuple[Frame | None, ...] = ()
    for frames in batch.run(0.1):  # noqa: B007
        if batch[0].time > 0.03:
            batch.leave(0)
    assert frames[0] is None
    assert batch[0].time < 0.05 < batch[1].time
    assert not batch.failures
    with pytest.raises(InputError, match=r"index of Batch\.leave"):
        batch.leave(2)


@pytest.mark.parametrize("threads", [1, 2])
def test_errors_of_a_users_own_code_end_the_batch(threads: int) -> None:
    class Wrong:
        def goals(self, view: BodyView) -> Goals:
            raise ZeroDivisionError

    batch = Batch(BAR, 2, lambda m: replace(m, controller=Wrong()), threads=threads)
    with pytest.raises(ZeroDivisionError):
        batch.step()


def test_a_member_needs_the_meshes_and_a_controller_of_its_own() -> None:
    finer = replace(PASSIVE, character=replace(PASSIVE.character, mesh=box((3, 2, 2))))
    with pytest.raises(InputError, match="member 0 of a Batch has other bodies or meshes"):
        Batch(PASSIVE, 2, lambda member: replace(member, scene=finer))
    one = Balance()
    with pytest.raises(InputError, match="members 0 and 1 of a Batch have one controller"):
        Batch(BAR, 2, lambda member: replace(member, controller=one))
    with pytest.raises(InputError, match="members 0 and 1 of a Batch have one controller"):
        Batch(BARS, 2, lambda member: replace(member, others={"second": one}))
    with pytest.raises(InputError, match="what vary of a Batch for member 0 returns"):
        Batch(BAR, 2, lambda member: None)  # type: ignore[arg-type,return-value]


@pytest.mark.parametrize("threads", [1, 2])
def test_forces_of_handles_are_those_of_single_runs(threads: int) -> None:
    """Though members work in the same arrays, and at different speeds; after a restore too."""
    block = Character(name="block", mesh=box(), material=Material(young_modulus=1e5))
    top = block.mesh.points[:, 2] > block.mesh.points[:, 2].max() - 1e-9
    block = replace(block, regions={"top": top})

    def pulled(speed: float) -> Scene:
        path = MotionPath.straight((speed, 0.0, 0.0))
        handle = Handle(region="top", path=path, until=0.1)
        return Scene(character=block, ground=Plane(offset=-0.02), handles=(handle,))

    speeds = (0.1, -0.3, 0.5)
    batch = Batch(
        pulled(0.0),
        len(speeds),
        lambda member: replace(member, scene=pulled(speeds[member.index])),
        threads=threads,
        time_step=1.0 / 60.0,
    )
    singles = [Simulation(pulled(speed), time_step=1.0 / 60.0) for speed in speeds]
    for step in range(8):
        batch.step()
        for member, single in zip(batch, singles, strict=True):
            single.step()
            force = single.handle_force("top")
            np.testing.assert_array_equal(member.handle_force("top"), force)
            assert force.any() == (step < 6)
            again = Simulation(single.model.scene, time_step=1.0 / 60.0)
            again.restore(single.save())
            np.testing.assert_array_equal(again.handle_force("top"), force)
