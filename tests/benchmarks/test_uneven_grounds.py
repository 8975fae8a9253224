"""Random grounds of slopes, hills, steps and stripes that a letter goes over."""

from __future__ import annotations

from argparse import Namespace

import pytest

from benchmarks.uneven_grounds import cross, settings_of

MIXED = Namespace(slope=15.0, roughness=0.05, steps=0.05, friction_stripes=0.5, friction=None)


@pytest.mark.long
@pytest.mark.parametrize(("ground", "lengths"), [(17, 3.2), (14, 3.8)])
def test_feet_that_come_down_on_steps_are_not_flung_away(ground: int, lengths: float) -> None:
    """Two edges of a foot on one edge of the ground, at nodes that the ground holds nearly."""
    found = cross("walk-x", settings_of("walk-x", ground, MIXED), lengths, 30.0)
    assert found.crossed(lengths)
