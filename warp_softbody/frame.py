"""What the run loop hands out: a snapshot of the scene at one time, in NumPy."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


class ContactMode(IntEnum):
    """What a touching point does (docs/method.md section 5)."""

    LIFT = 0
    STICK = 1
    SLIDE = 2


@dataclass(frozen=True, kw_only=True)
class ContactSample:
    """Touching nodes of one frame: of the ground, and of other surfaces.

    Attributes:
        nodes: (k,) int32, which touch; one that touches both stands twice.
        points: (k, 3) m.
        modes: (k,) int32, values of ContactMode.
        forces: (k, 3) N, onto the node.
    """

    nodes: npt.NDArray[np.int32] = field(default_factory=lambda: np.zeros(0, dtype=np.int32))
    points: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    modes: npt.NDArray[np.int32] = field(default_factory=lambda: np.zeros(0, dtype=np.int32))
    forces: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))


@dataclass(frozen=True, kw_only=True)
class Frame:
    """A snapshot; every array is a copy that the receiver may keep.

    Attributes:
        index: number of the frame, from 0.
        time: s.
        positions: (n, 3) m, nodes of all bodies in the order of Scene.parts.
        velocities: (n, 3) m/s.
        activations: (segments,) l_d / l_0; 1 for a slack segment.
        fiber_points: (p, 3) m, the vertices of all fibres in the order of Scene.whole.fibers.
        contacts: touching nodes.
        patches: what the controller planned for its patches in the step that led here, by their
            numbers, where it had a plan.
    """

    index: int
    time: float
    positions: FloatArray
    velocities: FloatArray
    activations: FloatArray
    fiber_points: FloatArray
    contacts: ContactSample
    patches: ContactSample = field(default_factory=ContactSample)
