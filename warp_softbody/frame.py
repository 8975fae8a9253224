"""What the run loop hands out: a snapshot of the scene at one time, in NumPy."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from warp_softbody import array_checks, checks, input_kinds
from warp_softbody.value import Value

FloatArray = npt.NDArray[np.float64]


class ContactMode(IntEnum):
    """What a touching point does (docs/method.md section 5)."""

    LIFT = 0
    STICK = 1
    SLIDE = 2

    @classmethod
    def _missing_(cls, value: object) -> ContactMode:
        """Refuse a number of none of the modes."""
        return input_kinds.member("ContactMode", value, cls)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class ContactSample(Value):
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

    def __post_init__(self) -> None:
        """Refuse what are no arrays of these shapes; whether they are finite is not asked here."""
        for name, shape in _SAMPLE_SHAPES.items():
            label = f"ContactSample.{name}"
            _check_array(label, getattr(self, name), shape)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Frame(Value):
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

    def __post_init__(self) -> None:
        """Refuse what are no arrays of these shapes; whether they are finite is not asked here."""
        index = checks.whole("Frame.index", self.index)
        checks.keep(self, index=index, time=checks.number("Frame.time", self.time, unit="s"))
        for name, shape in _FRAME_SHAPES.items():
            _check_array(f"Frame.{name}", getattr(self, name), shape)
        checks.instance("Frame.contacts", self.contacts, ContactSample)
        checks.instance("Frame.patches", self.patches, ContactSample)


_SAMPLE_SHAPES = {"nodes": (None,), "points": (None, 3), "modes": (None,), "forces": (None, 3)}
_FRAME_SHAPES = {
    "positions": (None, 3),
    "velocities": (None, 3),
    "activations": (None,),
    "fiber_points": (None, 3),
}


def _check_array(label: str, value: object, shape: tuple[int | None, ...]) -> None:
    """A frame hands its arrays on as they are, so only arrays are taken."""
    if not isinstance(value, np.ndarray):
        checks.refuse(label, "an array", value)
    array_checks.array(label, value, shape, finite=False)
