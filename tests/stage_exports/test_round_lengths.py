"""Grids have round lengths."""

from __future__ import annotations

import pytest

from warp_softbody.stage_exports.round_lengths import round_length


@pytest.mark.parametrize(
    ("length", "rounded"),
    [(1.0, 1.0), (1.0 - 1e-12, 1.0), (1.9, 1.0), (2.0 - 1e-12, 2.0), (0.049, 0.02), (7e3, 5e3)],
)
def test_a_length_is_rounded_down_but_for_its_own_rounding(length: float, rounded: float) -> None:
    assert round_length(length) == pytest.approx(rounded, rel=1e-12)
