"""The path of a foot that steps over an edge."""

from __future__ import annotations

import numpy as np
import pytest

from warp_softbody.controllers.motions.stepping_over import AHEAD, DOWN, UP, stepping_over

BEGIN, END = np.array([0.1, -0.2, 0.0]), np.array([0.44, -0.15, 0.05])


def test_it_begins_and_ends_at_rest_where_it_is_told() -> None:
    for share, expected in ((0.0, BEGIN), (1.0, END)):
        place, speed = stepping_over(BEGIN, END, 0.1, share)
        np.testing.assert_allclose(place, expected, atol=1e-15)
        np.testing.assert_allclose(speed, 0.0, atol=1e-15)


def test_it_is_up_before_it_is_half_way_and_comes_down_after() -> None:
    places = np.array(
        [stepping_over(BEGIN, END, 0.1, share)[0] for share in np.linspace(0, 1, 101)]
    )
    up = places[40:66]
    np.testing.assert_allclose(up[:, 2], 0.1, atol=1e-12)
    assert UP == 0.4 and DOWN == 0.65
    way = (places[:, 0] - BEGIN[0]) / (END[0] - BEGIN[0])
    assert (way[: round(100 * AHEAD[0])] == 0.0).all()
    assert way[40] < 0.2 and way[65] > 0.7
    assert (np.diff(way) >= 0.0).all() and places[:, 2].max() <= 0.1


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5, 0.7, 0.95])
def test_velocities_are_those_of_the_places(share: float) -> None:
    """Against central differences, of the second order."""
    h = 1e-5
    before, after = (stepping_over(BEGIN, END, 0.12, share + s)[0] for s in (-h, h))
    speed = stepping_over(BEGIN, END, 0.12, share)[1]
    np.testing.assert_allclose(speed, (after - before) / (2.0 * h), atol=1e-8)
