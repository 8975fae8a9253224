"""A path gives shift and turn at every time, in closed form."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from warp_softbody import MotionPath
from warp_softbody.errors import InputError


def path_of(times: Any, **given: Any) -> MotionPath:
    """A path of tuples, which are taken as arrays."""
    return MotionPath(times=times, **given)


X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def test_linear_path_holds_before_and_after() -> None:
    path = path_of((1.0, 3.0), shifts=((0.0, 0.0, 0.0), (4.0, 0.0, 2.0)))
    for time, part in ((-1.0, 0.0), (1.0, 0.0), (1.5, 0.25), (3.0, 1.0), (9.0, 1.0)):
        shift, angle = path.at(time)
        np.testing.assert_allclose(shift, part * np.array([4.0, 0.0, 2.0]), atol=1e-15)
        assert angle == 0.0


def test_eased_path_starts_and_stops() -> None:
    """Neither speed nor acceleration at either end: the error of both is of third order."""
    path = path_of((0.0, 1.0), shifts=((0, 0, 0), X), between="ease")
    assert path.at(0.5)[0][0] == pytest.approx(0.5, abs=1e-15)
    for h in (1e-2, 1e-3):
        assert path.at(h)[0][0] == pytest.approx(10.0 * h**3, rel=2.0 * h)
        assert 1.0 - path.at(1.0 - h)[0][0] == pytest.approx(10.0 * h**3, rel=2.0 * h)


def test_repeating_path_comes_back() -> None:
    path = path_of((0.0, 1.0, 2.0), shifts=((0, 0, 0), X, (0, 0, 0)), afterwards="repeat")
    for time in (0.25, 0.75, 1.5, 1.9):
        np.testing.assert_allclose(path.at(time + 6.0)[0], path.at(time)[0], atol=1e-14)
    whole = path_of((0.0, 1.0), degrees=(0.0, 360.0), afterwards="repeat")
    assert whole.at(7.25)[1] == pytest.approx(math.pi / 2.0)


def test_straight_and_spinning_go_on() -> None:
    np.testing.assert_allclose(MotionPath.straight((1.0, -2.0, 0.0)).at(7.0)[0], (7.0, -14.0, 0.0))
    spin = MotionPath.spinning(90.0, Z, center=(1.0, 0.0, 0.0))
    points = np.array([(2.0, 0.0, 0.5), (1.0, 0.0, 0.0)])
    np.testing.assert_allclose(spin.places(points, 3.0)[0], (1.0, -1.0, 0.5), atol=1e-12)
    np.testing.assert_allclose(spin.places(points, 3.0)[1], (1.0, 0.0, 0.0), atol=1e-15)
    own = MotionPath.spinning(180.0, Z).places(points, 1.0)
    np.testing.assert_allclose(own[::-1, :2], points[:, :2], atol=1e-12)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"times": (0.0, 0.0)}, "times in s that ascend"),
        ({"times": ()}, "ascend, at least one"),
        ({"times": (0.0,), "afterwards": "go_on"}, "needs two times"),
        ({"times": (0.0, 1.0), "between": "ease", "afterwards": "go_on"}, "with between 'linear'"),
        (
            {"times": (0.0, 1.0), "degrees": (0.0, 90.0), "afterwards": "repeat"},
            "ends are 0 m and 90 degrees apart",
        ),
        ({"times": (0.0, 1.0), "shifts": np.zeros((3, 3))}, r"MotionPath\.shifts"),
    ],
)
def test_what_is_no_path_is_refused(given: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        path_of(**given)
