"""The name of a run in the journal tells scenes apart by their muscles too."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.api.samples import muscled, scene
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.runs import job
from warp_softbody.scenes import ScenePlan


def of(character: Any, monkeypatch: pytest.MonkeyPatch) -> str:
    plan = ScenePlan(
        name="mine",
        description="",
        scene=replace(scene(), character=character),
        controller=None,
        seconds=1.0,
        time_step=0.01,
        settings={},
    )
    monkeypatch.setattr(Settings, "plan", lambda *_: plan)
    job.fingerprint.cache_clear()
    return job.fingerprint("mine", (), None)


def test_muscles_are_part_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    character = muscled()
    (group,) = character.muscles
    (fiber,) = group.fibers
    moved = replace(fiber, vertices=fiber.vertices + np.array([1e-9, 0.0, 0.0]))
    before = of(character, monkeypatch)
    assert of(muscled(), monkeypatch) == before
    for changed in (replace(group, strength=2e5), replace(group, fibers=(moved,))):
        assert of(replace(character, muscles=(changed,)), monkeypatch) != before
    job.fingerprint.cache_clear()
