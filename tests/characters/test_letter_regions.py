"""Regions of the letters are where their names say."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from warp_softbody import characters

FloatArray = NDArray[np.float64]
SIGNS = ((-1, -1), (1, -1), (-1, 1), (1, 1))


def box(name: str, region: str) -> FloatArray:
    """Lowest and highest corner (2, 3) of a region, m."""
    letter = characters.make(name)
    points = letter.mesh.points[letter.region(region)]
    return np.stack([points.min(axis=0), points.max(axis=0)])


@pytest.mark.parametrize("name", ["letter_h", "letter_f", "letter_t"])
def test_base_and_its_quadrants(name: str) -> None:
    letter = characters.make(name)
    base = letter.mesh.points[letter.region("base")]
    np.testing.assert_array_equal(base[:, 2], 0.0)
    reach = abs(base).max(axis=0)
    for i, (x, y) in enumerate(SIGNS):
        corners = box(name, f"base_patch_{i}")
        outermost = np.where(np.array([x, y]) > 0, corners[1, :2], corners[0, :2])
        np.testing.assert_allclose(outermost, [x * reach[0], y * reach[1]], atol=1e-9)
        assert (outermost * corners[:, :2] >= -1e-6).all()
    quarters = [set(letter.region(f"base_patch_{i}").tolist()) for i in range(4)]
    assert set.union(*quarters) == set(letter.region("base").tolist())


@pytest.mark.parametrize(
    ("name", "region", "low", "high"),
    [
        ("letter_h", "foot_left", (-0.4, -0.15, 0.0), (-0.12, 0.15, 0.0)),
        ("letter_h", "foot_right", (0.12, -0.15, 0.0), (0.4, 0.15, 0.0)),
        ("letter_h", "head_top", (-0.4, -0.15, 1.0), (0.4, 0.15, 1.0)),
        ("letter_h", "bar", (-0.12, -0.15, 0.4), (0.12, 0.15, 0.6)),
        ("letter_f", "head_top", (-0.16, -0.15, 1.0), (0.36, 0.15, 1.0)),
        ("letter_t", "head", (-0.36, -0.16, 0.84), (0.36, 0.16, 1.0)),
        ("letter_o", "rim", (-0.5, -0.15, 0.0), (0.5, 0.15, 1.0)),
        ("letter_i_flat", "belly", (-0.5, -0.2, 0.0), (0.5, 0.2, 0.0)),
        ("letter_i_flat", "tail", (-0.5, -0.2, 0.0), (-0.38, 0.2, 0.1)),
        ("letter_i_flat", "head", (0.38, -0.2, 0.0), (0.5, 0.2, 0.1)),
        ("letter_i_flat", "belly_0", (-0.5, -0.2, 0.0), (-0.38, 0.2, 0.0)),
        ("letter_i_flat", "belly_5", (0.38, -0.2, 0.0), (0.5, 0.2, 0.0)),
        ("letter_i_flat", "corner_0", (-0.5, -0.2, 0.0), (-0.38, -0.1, 0.0)),
        ("letter_i_flat", "corner_3", (0.38, 0.1, 0.0), (0.5, 0.2, 0.0)),
    ],
)
def test_boxes(
    name: str, region: str, low: tuple[float, float, float], high: tuple[float, float, float]
) -> None:
    np.testing.assert_allclose(box(name, region), [low, high], atol=1e-9)


def test_arms_lie_beyond_the_stem() -> None:
    assert box("letter_f", "arm_upper")[0, 0] > 0.12
    assert box("letter_f", "arm_upper")[0, 2] == pytest.approx(0.88)
    np.testing.assert_allclose(box("letter_f", "arm_lower")[:, 2], [0.44, 0.56])
    assert box("letter_t", "arm_left")[1, 0] < -0.16
    assert box("letter_t", "arm_right")[0, 0] > 0.16


def test_rim_parts_follow_one_another() -> None:
    letter = characters.letter_o()
    seen: set[int] = set()
    for part in range(20):
        x, _, z = letter.mesh.points[letter.region(f"rim-{part}")].mean(axis=0)
        angle = np.degrees(np.arctan2(x, 0.5 - z)) % 360.0
        assert angle == pytest.approx(18.0 * (part + 0.5), abs=1e-6)
        seen |= set(letter.region(f"rim-{part}").tolist())
    assert seen == set(letter.region("rim").tolist())


@pytest.mark.parametrize("limb", range(4))
def test_feet_and_limbs_stand_in_their_quadrants(limb: int) -> None:
    letter = characters.letter_x()
    foot = letter.mesh.points[letter.region(f"foot_{limb}")]
    np.testing.assert_array_equal(foot[:, 2], 0.0)
    along = foot[:, :2] @ np.array(SIGNS[limb]) / np.sqrt(2.0)
    # The foot is flat from 0.5 m to the end of the limb at 0.6071 m.
    assert along.min() >= 0.5 - 1e-6 and along.max() == pytest.approx(0.6071, abs=1e-6)
    limbs = letter.mesh.points[letter.region(f"limb_{limb}")]
    assert (limbs[:, :2] * np.array(SIGNS[limb]) >= -1e-6).all()


@pytest.mark.parametrize("limb", range(4))
def test_feet_of_the_upright_x_are_alike_after_a_quarter_turn(limb: int) -> None:
    letter = characters.letter_x_upright()
    middle = np.array([0.0, 0.0, 0.5])
    foot, first = (letter.mesh.points[letter.region(f"foot_{name}")] - middle for name in (limb, 0))
    turned = first.copy()
    for _ in range(limb):
        # anticlockwise seen from the front, x towards z
        turned = turned[:, [2, 1, 0]] * np.array([-1.0, 1.0, 1.0])
    assert np.ptp(foot, axis=0) == pytest.approx(np.ptp(turned, axis=0), abs=1e-9)
    assert foot.mean(axis=0) == pytest.approx(turned.mean(axis=0), abs=0.02)
    quarters = [set(letter.region(f"foot_{limb}_{part}").tolist()) for part in range(4)]
    assert set.union(*quarters) == set(letter.region(f"foot_{limb}").tolist())
    assert set.union(*quarters) <= set(letter.region("rim").tolist())


def test_hub_of_the_walker_is_off_the_ground() -> None:
    assert box("letter_x", "hub")[0, 2] == pytest.approx(0.2)


def test_belly_parts_cover_the_belly() -> None:
    letter = characters.letter_i_flat()
    parts = [set(letter.region(f"belly_{i}").tolist()) for i in range(6)]
    assert set.union(*parts) == set(letter.region("belly").tolist())
