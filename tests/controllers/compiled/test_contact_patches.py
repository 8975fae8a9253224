"""Patches by native code against those that NumPy makes."""

from __future__ import annotations

import copy
import pickle
from dataclasses import fields, replace

import numpy as np
import pytest

from tests.support.blocks import bent, block, dunes, pressed, seen
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.controllers import contact_quadrature
from warp_softbody.controllers.compiled.contact_patches import CompiledPatches
from warp_softbody.controllers.patches import Patch, ground_patches
from warp_softbody.errors import InputError
from warp_softbody.kernels.control.contact_patches import LIMITS
from warp_softbody.run.simulation import Simulation
from warp_softbody.scenes import make
from warp_softbody.world.ground import Ground, Plane
from warp_softbody.world.view import BodyView


def in_run(view: BodyView, workroom: dict[object, object]) -> BodyView:
    """The view as a run hands it out, with room for native code."""
    own = replace(view)
    object.__setattr__(own, "workroom", workroom)
    return own


def same(found: tuple[Patch, ...], expected: tuple[Patch, ...]) -> None:
    """Every field, to rounding; frames turn with the fourth root of a small number."""
    assert len(found) == len(expected) > 0
    for one, other in zip(found, expected, strict=True):
        for name in (entry.name for entry in fields(Patch)):
            value, wanted = getattr(one, name), getattr(other, name)
            if name == "part":
                assert value is wanted is None
                continue
            np.testing.assert_allclose(value, wanted, rtol=1e-9, atol=1e-11, err_msg=name)
        assert one.touching is other.touching and isinstance(one.gap, float)


def moved(character: Character, seed: int) -> FloatArray:
    rng = np.random.default_rng(seed)
    return bent(character.mesh.points, 0.02 * seed) + 1e-3 * rng.standard_normal((1, 3))


@pytest.mark.parametrize("loaded", [False, True])
@pytest.mark.parametrize("ground", [Plane(normal=(0.1, 0.2, 1.0)), dunes()], ids=["plane", "field"])
@pytest.mark.parametrize("plain", [False, True])
def test_patches_are_those_of_the_numpy_form(ground: Ground, loaded: bool, plain: bool) -> None:
    """Parts with nodes in common, with and without directions of friction, step after step."""
    character = block(1)
    rooms: dict[object, object] = {}
    if plain:
        character = replace(character, directional_friction=())
    rng = np.random.default_rng(3)
    for seed in range(4):
        view = (pressed if loaded else seen)(character, moved(character, seed), ground)
        view = replace(view, velocities=0.1 * rng.standard_normal(view.positions.shape))
        view = replace(view, touching=rng.random(view.node_count) < 0.05 * seed)
        for regions in (("left", "right"), ("foot",)):
            found = ground_patches(in_run(view, rooms), regions)
            same(found, ground_patches(view, regions))
    assert sum(isinstance(known, CompiledPatches) for known in rooms.values()) == 2


def test_parts_without_a_surface_and_alone_at_rest() -> None:
    """One node within the body counts alone; a body that nothing moved has its own axes."""
    plain = block()
    inner = np.setdiff1d(np.arange(len(plain.mesh.points)), plain.mesh.surface_nodes)
    character = replace(plain, regions={**plain.regions, "inner": inner[:1].astype(np.int32)})
    view = seen(character, character.mesh.points.copy(), Plane(normal=(1.0, 0.0, 0.2)))
    for regions in (("inner",), ("inner", "foot")):
        same(ground_patches(in_run(view, {}), regions), ground_patches(view, regions))


def test_a_run_in_numpy_sees_what_a_native_one_does() -> None:
    """The first patches of a crawl, whose friction has directions."""
    plan = make("crawl-i")
    simulation = Simulation(plan.scene, plan.controller, time_step=plan.time_step)
    regions = tuple(f"belly_{k}" for k in range(6))
    for _ in range(40):
        simulation.step()
        view = simulation.view()
        assert view.workroom is not None
        same(ground_patches(view, regions), ground_patches(replace(view), regions))


def test_a_view_s_room_is_no_part_of_its_state() -> None:
    view = seen(block(), block().mesh.points.copy(), Plane())
    own = in_run(view, {})
    ground_patches(own, ("foot",))
    assert own == view and own.workroom
    assert copy.deepcopy(own).workroom is None
    assert pickle.loads(pickle.dumps(own)).workroom is None
    assert replace(own).workroom is None


def test_positions_that_are_not_finite_are_refused_alike() -> None:
    character = block()
    positions = character.mesh.points.copy()
    positions[character.region("foot")[0]] = np.nan
    view = seen(character, positions, Plane())
    said = []
    for each in (view, in_run(view, {})):
        with np.errstate(all="ignore"), pytest.raises(InputError) as refused:
            ground_patches(each, ("foot",))
        said.append(str(refused.value))
    assert said[0] == said[1]


def test_limits_are_those_of_the_numpy_form() -> None:
    for name, value in LIMITS.items():
        assert getattr(contact_quadrature, name) == float(value)
