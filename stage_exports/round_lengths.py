"""Grids have round lengths, so that distances can be read off them."""

from __future__ import annotations

import numpy as np


def round_length(length: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is not above a length, to rounding."""
    most = length * 1.0001
    power = 10.0 ** np.floor(np.log10(most))
    return float(power * max(step for step in (1.0, 2.0, 5.0) if step * power <= most))
