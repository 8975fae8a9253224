"""Colours with a meaning are the same in stages and pictures; linear RGB in 0..1."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray

GROUND = (0.20, 0.22, 0.25)
GROUND_DARK = (0.13, 0.145, 0.165)

_SLIPPERY, _ROUGH, _STEEPNESS = 1.6, 0.5, 0.6
"""Of a ground: brightness without friction, the least one, and what a factor of one takes off."""

# Slack fibres are ivory; the harder one contracts, the bluer it gets. Ivory and blue both stand out
# on warm and on neutral bodies, and differ in lightness, so the scale also reads without colour.
_CONTRACTION = np.array([0.0, 0.15, 0.5])
_COLORS = np.array([[0.86, 0.80, 0.62], [0.16, 0.62, 0.78], [0.02, 0.05, 0.42]])

_STEPS = 64
"""Of activations, that stages tell apart by colour."""

# Lift, stick, slide, by the value of ContactMode.
_MODES = np.array([[0.60, 0.60, 0.60], [0.10, 0.60, 0.15], [0.95, 0.45, 0.05]])


def friction_shade(factors: npt.ArrayLike) -> FloatArray:
    """Brightness of a ground by factors on its friction: 1 at 1, more where it slips."""
    return np.maximum(_SLIPPERY - _STEEPNESS * np.asarray(factors, dtype=np.float64), _ROUGH)


def activation_colors(activations: npt.ArrayLike) -> FloatArray:
    """(s, 3) colours of muscle segments by l_d / l_0, from 1 (slack) to 0.5 (fully contracted)."""
    contraction = np.clip(1.0 - np.asarray(activations, dtype=np.float64), 0.0, 0.5)
    channels = [np.interp(contraction, _CONTRACTION, _COLORS[:, channel]) for channel in range(3)]
    return np.stack(channels, axis=-1)


def activation_palette() -> FloatArray:
    """(64, 3) colours of equal steps from slack to fully contracted."""
    return activation_colors(np.linspace(1.0, 0.5, _STEPS))


def activation_steps(activations: npt.ArrayLike) -> npt.NDArray[np.int32]:
    """(s,) places in the palette of activations."""
    contraction = 1.0 - np.asarray(activations, dtype=np.float64)
    share = np.clip(contraction / 0.5, 0.0, 1.0)
    return np.asarray(np.rint(share * (_STEPS - 1)), dtype=np.int32)


def mode_palette() -> FloatArray:
    """(3, 3) colours of contacts by ContactMode."""
    return np.array(_MODES, dtype=np.float64)
