"""What a page is told of a ground."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import warp_softbody as wsb
from warp_softbody.live.outline import ground_as_json

GROUNDS: dict[str, wsb.Plane | wsb.HeightField] = {
    "plane": wsb.Plane(offset=0.2),
    "field": wsb.HeightField(heights=np.zeros((3, 4)), spacing=(0.5, 0.5)),
}


@pytest.mark.parametrize("kind", GROUNDS)
def test_a_page_is_told_where_friction_differs(kind: str) -> None:
    ground = GROUNDS[kind]
    factors = np.array([[1.0, 0.5, 0.25], [0.0, 2.0, 1.0 / 3.0]])
    placed = wsb.FrictionMap(factors=factors, spacing=(0.5, 0.25), origin=(-1.0, 2.0))
    plain, told = (ground_as_json(one) for one in (ground, replace(ground, friction_map=placed)))
    assert plain is not None and told is not None and "friction" not in plain
    friction = told.pop("friction")
    assert told == plain
    assert friction == {
        "factors": [1.0, 0.5, 0.25, 0.0, 2.0, 0.33333],
        "columns": 3,
        "spacing": [0.5, 0.25],
        "origin": [-1.0, 2.0],
    }
