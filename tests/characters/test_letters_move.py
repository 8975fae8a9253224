"""Letters stand by themselves, and their muscles do what their kinds are for."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.support.bodies import Rig, rig
from warp_softbody import characters
from warp_softbody.body.mesh_geometry import tet_volumes
from warp_softbody.body.muscles import FiberKind
from warp_softbody.world.ground import Plane

GRAVITY = (0.0, 0.0, -9.81)


def contracted(name: str, part: str, gravity: tuple[float, float, float]) -> Rig:
    """A letter on the floor half a second after the fibres with a text in their names contract."""
    letter = characters.make(name)
    body = rig(letter, ground=Plane(friction=0.8), gravity=gravity, time_step=1.0 / 60.0)
    body.activate(
        [0.5 if part in f.name else 1.02 for f in letter.fibers for _ in range(f.segment_count)]
    )
    body.step(30)
    return body


@pytest.mark.parametrize("name", characters.names())
def test_stands_by_itself(name: str) -> None:
    letter = characters.make(name)
    body = rig(letter, ground=Plane(friction=0.8), gravity=GRAVITY, time_step=1.0 / 60.0)
    for _ in range(18):
        assert body.step().finite
    assert (tet_volumes(body.positions, letter.mesh.tets) > 0.0).all()
    # Touching nodes lie on the ground to the rounding of single precision.
    assert body.positions[:, 2].min() > -1e-5
    assert body.statistics is not None and body.statistics.touching > 0
    # None falls: even the O and the X sink by less than a tenth of their height.
    height = np.ptp(letter.mesh.points[:, 2])
    assert body.positions[:, 2].max() > 0.9 * height


@pytest.mark.parametrize("name", ["letter_h", "letter_i_jump"])
def test_longitudinal_fibers_shorten_and_radial_ones_lengthen(name: str) -> None:
    still = (0.0, 0.0, 0.0)
    assert np.ptp(contracted(name, "longitudinal", still).positions[:, 2]) < 0.9
    assert np.ptp(contracted(name, "radial", still).positions[:, 2]) > 1.05


def test_right_handed_helices_turn_the_head_clockwise() -> None:
    letter = characters.letter_t()
    positions = contracted("letter_t", "helical", (0.0, 0.0, 0.0)).positions
    head, base = (
        turn_about_z(letter.mesh.points[letter.region(r)], positions[letter.region(r)])
        for r in ("head_top", "base")
    )
    assert head - base < -np.radians(20.0)
    assert all(f.kind is FiberKind.HELICAL for f in letter.fibers if f.name.startswith("helical"))


def turn_about_z(before: NDArray[np.float64], after: NDArray[np.float64]) -> float:
    """Angle in rad, anticlockwise from above, that best turns one set of points into another."""
    p, q = (points[:, :2] - points[:, :2].mean(axis=0) for points in (before, after))
    return float(np.arctan2((p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum(), (p * q).sum()))


def test_lower_strands_arch_the_crawler() -> None:
    letter = characters.letter_i_flat()
    middle = letter.region("belly_2")
    lifted = contracted("letter_i_flat", "lower", GRAVITY).positions[middle, 2]
    assert lifted.mean() > 0.05


def test_upper_strands_lift_a_limb_of_the_walker() -> None:
    letter = characters.letter_x()
    foot = letter.region("foot_0")
    still = contracted("letter_x", "longitudinal_0_2", (0.0, 0.0, 0.0)).positions
    assert (still - letter.mesh.points)[foot, 2].mean() > 0.05
