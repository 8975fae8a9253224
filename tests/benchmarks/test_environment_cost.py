"""The benchmark of environments compares steps that are the same; times are hardly judged here."""

from __future__ import annotations

import pytest

pytest.importorskip("gymnasium")
from benchmarks.environment_cost import cost
from warp_softbody import characters


def test_both_sides_take_the_same_steps() -> None:
    found = cost(characters.letter_i(coarse=1), 0.2, 400)
    assert found.same
    assert found.step > 0.0
    # 1.02 to 1.03 on machines that do nothing else
    assert found.ratio < 1.15
