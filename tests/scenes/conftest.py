"""Motions that several tests measure."""

from __future__ import annotations

from functools import cache

import pytest

from benchmarks.motions.criterion import RecordedMotion
from tests.scenes.runs import Shipped, run


@pytest.fixture(scope="session")
def shipped(tmp_path_factory: pytest.TempPathFactory) -> Shipped:
    """The motion of a scene as it is shipped, run once however many tests measure it."""

    @cache
    def motion(scene: str) -> RecordedMotion:
        return run(scene, tmp_path_factory.mktemp(scene))

    return motion
