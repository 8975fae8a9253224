"""Environments: Gymnasium's own checks, bits that repeat, rewards, ends and frames."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

gymnasium = pytest.importorskip("gymnasium")
from gymnasium.utils.env_checker import check_env  # noqa: E402

from warp_softbody import (  # noqa: E402
    BatchMember,
    Environment,
    Plane,
    Push,
    Scene,
    StageWriter,
    VectorEnvironment,
    characters,
)
from warp_softbody.environment.episode import progress  # noqa: E402
from warp_softbody.errors import InputError  # noqa: E402
from warp_softbody.stage_exports import read_take  # noqa: E402

LETTER = characters.letter_i(coarse=1)
SCENE = Scene(character=LETTER, ground=Plane())
FIBERS = len(LETTER.fibers)

Actions = npt.NDArray[np.float32]


def actions(count: int, seed: int = 0) -> Actions:
    numbers = np.random.default_rng(seed).uniform(0.0, 1.0, (count, FIBERS))
    return numbers.astype(np.float32)


def test_the_checker_passes() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*spec.*")
        check_env(Environment(SCENE, seconds=0.3, start_speed=0.2, render_mode="rgb_array"))


def test_bits_repeat_and_are_kept() -> None:
    one, other = (Environment(SCENE, start_speed=0.3) for _ in range(2))
    first = [one.reset(seed=7)[0], *(one.step(each)[0] for each in actions(5))]
    kept = one.save()
    later = [one.step(each)[:3] for each in actions(6, 1)]
    again = [one.reset(seed=7)[0], *(one.step(each)[0] for each in actions(5))]
    np.testing.assert_array_equal(first, again)
    np.testing.assert_array_equal(other.restore(kept), first[-1])
    for wanted, found in zip(later, (other.step(each)[:3] for each in actions(6, 1)), strict=True):
        np.testing.assert_array_equal(wanted[0], found[0])
        assert wanted[1:] == found[1:]
    assert other.save().taken == 11


def test_what_is_observed() -> None:
    environment = Environment(SCENE)
    seen, _ = environment.reset(seed=0)
    np.testing.assert_allclose(seen[:7], 0.0, atol=1e-6)
    orientation = seen[7:16].reshape(3, 3)
    assert np.trace(orientation) == pytest.approx(1.0, abs=1e-5)
    np.testing.assert_allclose(seen[16 : 16 + FIBERS], 0.0, atol=1e-4)
    for _ in range(20):
        seen, *_ = environment.step(np.full(FIBERS, 0.6, np.float32))
    # what contracts is shorter, and the quarters of the sole, which overlap, bear the weight
    assert (seen[16 : 16 + FIBERS] < -0.01).all()
    np.testing.assert_allclose(seen[16 + FIBERS : 16 + 2 * FIBERS], 0.6, atol=1e-5)
    loads = seen[16 + 2 * FIBERS :]
    assert loads.sum() > 0.8
    assert ((loads >= 0.0) & (loads < 1.0)).all()


def test_sums_are_those_of_numpy() -> None:
    """All numbers but the contractions, from the frame and the view of a body in motion."""
    environment = Environment(SCENE, start_speed=0.5)
    environment.reset(seed=3)
    for action in actions(6):
        seen, *_ = environment.step(action)
    view = environment.simulation.view()
    frame = environment.simulation.frame()
    points, masses = LETTER.mesh.points, view.masses
    middle = masses @ points / masses.sum()
    arms, speed = points - middle, np.sqrt(9.81 * 1.0)
    spread = float((masses[:, None] * arms**2).sum())
    orientation = (arms * masses[:, None]).T @ (view.positions - view.center_of_mass) / spread
    lengths = []
    for fiber, ends in zip(LETTER.fibers, fiber_points(frame.fiber_points), strict=True):
        rest = np.linalg.norm(np.diff(fiber.vertices, axis=0), axis=1).sum()
        lengths.append(np.linalg.norm(np.diff(ends, axis=0), axis=1).sum() / rest - 1.0)
    feet = [view.impulses[LETTER.region(f"base_patch_{k}"), 2].sum() for k in range(4)]
    wanted = [
        [view.center_of_mass[2] - middle[2]],
        view.linear_momentum / view.mass / speed,
        view.angular_momentum / view.mass / speed,
        orientation.ravel(),
        lengths,
        action,
        np.array(feet) / (view.weight * view.time_step),
    ]
    np.testing.assert_allclose(seen, np.concatenate(wanted), rtol=2e-6, atol=2e-6)


def fiber_points(points: npt.NDArray[np.float64]) -> list[npt.NDArray[np.float64]]:
    """The vertices of each fibre as they are now."""
    counts = [len(fiber.vertices) for fiber in LETTER.fibers]
    return np.split(points, np.cumsum(counts)[:-1])


def test_rewards_of_one_s_own_are_those_of_the_usual_ones() -> None:
    """Views are made only for those who ask for them; what comes of them is the same."""
    usual = Environment(SCENE, start_speed=0.5)
    own = Environment(SCENE, start_speed=0.5, reward=lambda *views: progress(*views))
    for environment in (usual, own):
        environment.reset(seed=2)
    for action in actions(4):
        one, other = (environment.step(action) for environment in (usual, own))
        np.testing.assert_array_equal(one[0], other[0])
        assert one[1] == pytest.approx(other[1], rel=1e-9, abs=1e-12)


def test_rewards_and_ends() -> None:
    moved = Scene(character=LETTER, initial_velocity=(0.6, 0.0, 0.0), gravity=(0.0, 0.0, 0.0))
    environment = Environment(moved, seconds=0.5, steps=6)
    environment.reset(seed=0)
    still = np.zeros(FIBERS, np.float32)
    outcomes = [environment.step(still) for _ in range(5)]
    for _, reward, ended, _, _ in outcomes:
        # 0.6 m/s for 0.1 s, of a body of 1 m
        assert reward == pytest.approx(0.06, abs=1e-4)
        assert not ended
    assert [cut for _, _, _, cut, _ in outcomes] == [False] * 4 + [True]
    ends = Environment(moved, ends=lambda view: view.time > 0.15, steps=6)
    ends.reset(seed=0)
    assert [ends.step(still)[2] for _ in range(2)] == [False, True]


def test_many_give_the_bits_of_one() -> None:
    def vary(member: BatchMember) -> BatchMember:
        push = Push(region="head", force=(40.0 * member.index, 0.0, 0.0), start=0.0, duration=0.2)
        return replace(member, scene=replace(SCENE, pushes=(push,)))

    many = VectorEnvironment(SCENE, 3, vary, threads=2, seconds=0.2, start_speed=0.2)
    seen, _ = many.reset(seed=5)
    for index, member in enumerate(many.batch):
        alone = Environment(member.model.scene, seconds=0.2, start_speed=0.2)
        np.testing.assert_array_equal(alone.reset(seed=5 + index)[0], seen[index])
    alone.reset(seed=7)
    for number, action in enumerate(actions(3)):
        seen, rewards, ended, cut, info = many.step(np.tile(action, (3, 1)))
        wanted = alone.step(action)
        np.testing.assert_array_equal(seen[2], wanted[0])
        assert (rewards[2], ended[2], cut[2]) == wanted[1:4]
        assert info["time"][2] == wanted[4]["time"]
        assert cut.all() == (number == 2)
    seen, rewards, ended, cut, info = many.step(np.ones((3, FIBERS), np.float32))
    assert not rewards.any() and not cut.any() and not info["time"].any()


def test_a_body_that_numbers_fail_on_starts_anew() -> None:
    wild = Push(region="head", force=(1e25, 0.0, 0.0), start=0.05, duration=0.1)
    environments = VectorEnvironment(replace(SCENE, pushes=(wild,)), 2)
    environments.reset(seed=0)
    still = np.zeros((2, FIBERS), np.float32)
    assert environments.step(still)[2].all()
    seen, rewards, ended, cut, _ = environments.step(still)
    np.testing.assert_allclose(seen[:, :7], 0.0, atol=1e-6)
    assert not (rewards.any() or ended.any() or cut.any())


def test_frames_go_to_a_stage(tmp_path: Path) -> None:
    environment = Environment(SCENE, steps=2)
    with StageWriter(tmp_path / "e.usdc", SCENE, fps=environment.simulation.fps) as stage:
        environment.watch(stage.write)
        environment.reset(seed=0)
        for each in actions(4):
            environment.step(each)
    assert len(read_take(tmp_path / "e.usdc")) == 5
    assert environment.render() is None


def test_wrong_actions_are_told() -> None:
    environment = Environment(SCENE)
    environment.reset(seed=0)
    with pytest.raises(InputError, match="action of an Environment must hold contractions from 0"):
        environment.step(np.full(FIBERS, 1.5, np.float32))
    with pytest.raises(InputError, match="action of an Environment"):
        environment.step(np.zeros(1, np.float32))
    with pytest.raises(InputError, match="needs muscles"):
        Environment(replace(SCENE, character=replace(LETTER, muscles=())))


def test_no_step_before_a_reset_or_after_a_close() -> None:
    one, many = Environment(SCENE), VectorEnvironment(SCENE, 1)
    for environment, action in ((one, actions(1)[0]), (many, actions(1))):
        with pytest.raises(InputError, match="needs a reset first"):
            environment.step(action)
        environment.reset(seed=0)
        environment.step(action)
        environment.close()
        with pytest.raises(InputError, match="needs a reset first"):
            environment.step(action)


def test_an_episode_of_another_environment_is_refused() -> None:
    kept = Environment(SCENE).save()
    icy = replace(SCENE, ground=Plane(friction=0.1))
    for other, told in (
        (Environment(icy), "of the same scene alone"),
        (Environment(SCENE, steps=2), "actions held for 4 steps"),
        (Environment(SCENE, muscles="segments"), "of other muscles"),
        (Environment(SCENE, time_step=1 / 120), "time steps of 0.0166667 s"),
    ):
        with pytest.raises(InputError, match=told):
            other.restore(kept)


@pytest.mark.parametrize("given", [float("nan"), "x", None])
def test_a_reward_is_a_finite_number(given: object) -> None:
    environment = Environment(SCENE, reward=lambda before, after: given)  # type: ignore[arg-type, return-value]
    environment.reset(seed=0)
    with pytest.raises(InputError, match="what the reward of an Environment returns"):
        environment.step(actions(1)[0])


def test_as_many_seeds_as_environments() -> None:
    with pytest.raises(InputError, match="must be one number or 2 of them, not 1"):
        VectorEnvironment(SCENE, 2).reset(seed=[1])
