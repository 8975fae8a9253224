"""The first frame tells what stands on the ground."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from warp_softbody import scenes
from warp_softbody.contact_mode import ContactMode
from warp_softbody.run.simulation import Simulation
from warp_softbody.world.standing import standing_contacts


def test_the_first_frame_of_a_letter_has_its_base_as_contacts() -> None:
    plan = scenes.make("balance-i")
    frame = next(Simulation(plan.scene, plan.controller).run(1.0))
    lowest = frame.positions[:, 2] <= frame.positions[:, 2].min() + 1e-6
    assert sorted(frame.contacts.nodes.tolist()) == np.flatnonzero(lowest).tolist()
    assert set(frame.contacts.modes.tolist()) == {int(ContactMode.STICK)}
    assert not frame.contacts.forces.any()
    assert frame.contacts.names == ("letter_i",)


def test_what_is_in_the_air_has_none() -> None:
    assert not len(next(Simulation(scenes.make("drop-block").scene).run(1.0)).contacts.nodes)


def test_without_a_ground_there_is_none() -> None:
    scene = replace(scenes.make("balance-i").scene, ground=None)
    assert not len(standing_contacts(scene, scene.whole.mesh.points).nodes)


@pytest.mark.parametrize("ground", ["slope", "stack"])
def test_the_second_frame_agrees(ground: str) -> None:
    """A body that stands still goes on to touch with the nodes that it stood on."""
    frames = Simulation(scenes.make(ground).scene, time_step=1e-3, fps=1000.0).run(0.002)
    first, second = next(frames), next(frames)
    assert len(first.contacts.nodes)
    assert set(first.contacts.nodes.tolist()) <= set(second.contacts.nodes.tolist())
