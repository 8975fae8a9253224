"""A `Frame` is a snapshot of the scene at one time, in NumPy, as the run loop yields it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks
from warp_softbody.inputs.records import Value

IntArray = npt.NDArray[np.int32]


GROUND = -1
"""The number that stands for the ground among those of the bodies."""


def _numbers() -> IntArray:
    return np.zeros(0, dtype=np.int32)


def _vectors() -> FloatArray:
    return np.zeros((0, 3))


def _triples() -> IntArray:
    return np.zeros((0, 3), dtype=np.int32)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class ContactSample(Value):
    """The contacts of one frame: which nodes touch, where, and with which force.

    Bodies are numbered as in Scene.parts, nodes through all bodies. A node that touches several
    things stands several times; an edge that touches another stands once for each of its ends. What
    two surfaces do to each other stands once: the nodes of the other side bear the opposite force
    by their weights.

    Attributes:
        nodes: (k,) int32, which touch.
        points: (k, 3) m.
        modes: (k,) int32, values of ContactMode.
        forces: (k, 3) N, onto the node.
        bodies: (k,) int32, the node's; the first where none are given.
        partners: (k,) int32, the body on the other side, or GROUND; the same as the node's own
            where a body touches itself. GROUND where none are given.
        partner_nodes: (k, 3) int32, the nodes on the other side: corners of a triangle, or ends of
            an edge; -1 where there are fewer, or the ground.
        partner_weights: (k, 3) where between them, adding up to one; zero for the ground.
        names: of the bodies, by their numbers.
    """

    nodes: IntArray = field(default_factory=_numbers)
    points: FloatArray = field(default_factory=_vectors)
    modes: IntArray = field(default_factory=_numbers)
    forces: FloatArray = field(default_factory=_vectors)
    bodies: IntArray = field(default_factory=_numbers)
    partners: IntArray = field(default_factory=_numbers)
    partner_nodes: IntArray = field(default_factory=_triples)
    partner_weights: FloatArray = field(default_factory=_vectors)
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Contacts of the first body with the ground, where nothing else is said.

        What are no arrays of these shapes is refused; whether they are finite is not asked here.
        """
        for name, shape in _SAMPLE_SHAPES.items():
            _check_array(f"ContactSample.{name}", getattr(self, name), shape)
        count = len(self.points)
        for name, value, shape in (
            ("bodies", 0, (count,)),
            ("partners", GROUND, (count,)),
            ("partner_nodes", -1, (count, 3)),
        ):
            if len(getattr(self, name)) != count:
                object.__setattr__(self, name, np.full(shape, value, dtype=np.int32))
        if len(self.partner_weights) != count:
            object.__setattr__(self, "partner_weights", np.zeros((count, 3)))

    def force_on(self, body: int | str, by: int | str | None = None) -> FloatArray:
        """Return the force (3,) N that acts on a body through its contacts.

        Args:
            body: its number in Scene.parts, or its name.
            by: number or name of the body that it comes from, or GROUND; None for all together.

        Raises:
            InputError: where no body has the name or the number.
        """
        own = self._number(body)
        other = None if by is None else self._number(by, ground=True)
        onto = self.bodies == own
        against = self.partners == own
        if other is not None:
            onto = onto & (self.partners == other)
            against = against & (self.bodies == other)
        return np.asarray(self.forces[onto].sum(axis=0) - self.forces[against].sum(axis=0))

    def seen_by(self, body: int, positions: FloatArray) -> ContactSample:
        """Return all contacts on a body's own nodes; their forces add up to the force on it.

        Beside its own samples, a triangle that another's node touches stands once for each of its
        corners that bear a part, with that node on the other side.

        Args:
            body: its number in Scene.parts.
            positions: (n, 3) m, of all nodes.
        """
        onto = np.flatnonzero(self.bodies == body)
        against, corner = np.nonzero(
            (self.partners == body)[:, None] & (self.partner_weights > 0.0)
        )
        shares = self.partner_weights[against, corner][:, None]
        back = np.full((len(against), 3), -1, dtype=np.int32)
        back[:, 0] = self.nodes[against]
        one = np.zeros((len(against), 3))
        one[:, 0] = 1.0
        nodes = self.partner_nodes[against, corner]
        twice = len(onto) + len(against)
        return replace(
            self,
            nodes=np.concatenate([self.nodes[onto], nodes]),
            points=np.concatenate([self.points[onto], positions[nodes]]),
            modes=np.concatenate([self.modes[onto], self.modes[against]]),
            forces=np.concatenate([self.forces[onto], -shares * self.forces[against]]),
            bodies=np.full(twice, body, dtype=np.int32),
            partners=np.concatenate([self.partners[onto], self.bodies[against]]),
            partner_nodes=np.concatenate([self.partner_nodes[onto], back]),
            partner_weights=np.concatenate([self.partner_weights[onto], one]),
        )

    def _number(self, body: int | str, *, ground: bool = False) -> int:
        if isinstance(body, str):
            if body not in self.names:
                known = ", ".join(map(repr, self.names)) or "none"
                raise InputError(f"no body of these contacts is named {body!r}, there are {known}")
            return self.names.index(body)
        if ground and body == GROUND:
            return GROUND
        if self.names and not 0 <= body < len(self.names):
            raise InputError(
                f"a body of these contacts has a number from 0 to {len(self.names) - 1}, "
                f"got {body!r}"
            )
        return int(body)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Frame(Value):
    """A snapshot of the scene; every array is a copy that the receiver may keep.

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


_SAMPLE_SHAPES = {
    "nodes": (None,),
    "points": (None, 3),
    "modes": (None,),
    "forces": (None, 3),
    "bodies": (None,),
    "partners": (None,),
    "partner_nodes": (None, 3),
    "partner_weights": (None, 3),
}
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
