"""A `Scene` has bodies, the ground they stand on, and the forces that push them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.inputs.records import FrozenValue
from warp_softbody.world.force_fields import ForceField
from warp_softbody.world.ground import Ground, checked_ground
from warp_softbody.world.handles import Handle, acted_on, nodes_of_handles, pushed_nodes
from warp_softbody.world.height_field import HeightField
from warp_softbody.world.joined_bodies import Body, Part, Vector, checked_pose, join, parts_of

STANDARD_GRAVITY = 9.81


@dataclass(frozen=True, kw_only=True)
class Push:
    """A force that acts on a region of the character for a while, distributed by nodal mass.

    Attributes:
        region: name of the region that is pushed.
        force: total force, N, (x, y, z).
        start: s.
        duration: s.
    """

    region: str
    force: tuple[float, float, float]
    start: float
    duration: float

    def __post_init__(self) -> None:
        """Refuse numbers that are not finite and negative durations."""
        input_kinds.name("Push.region", self.region)
        checks.keep(
            self,
            force=checks.vector("Push.force", self.force, unit="N"),
            start=checks.number("Push.start", self.start, unit="s"),
            duration=checks.number("Push.duration", self.duration, low=0.0, unit="s"),
        )

    def share(self, start: float, end: float) -> float:
        """Fraction of the interval [start, end] s during which the push acts."""
        overlap = min(end, self.start + self.duration) - max(start, self.start)
        return max(0.0, overlap) / (end - start)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Scene(FrozenValue):
    """Everything that is simulated: bodies, ground, gravity, and all that acts or moves.

    Attributes:
        character: the body; the one that a controller moves.
        others: bodies beside it, which touch it and each other.
        ground: a plane, a height field or triangles; None for bodies in free space.
        gravity: m/s^2.
        pushes: forces over time.
        handles: nodes that are moved along paths.
        fields: forces by place, velocity and time, beside gravity.
        initial_velocity: of every node of the character, m/s.
        initial_spin: of the character about its centre of mass, rad/s.
        initial_pose: (n, 3) m, where the character's nodes are; None for its shape at rest.
        body_friction: Coulomb coefficient between bodies, and of a surface with itself.
        self_contact: whether surfaces of one body touch each other.
    """

    character: Character
    others: tuple[Body, ...] = ()
    ground: Ground | None = None
    gravity: tuple[float, float, float] = (0.0, 0.0, -STANDARD_GRAVITY)
    pushes: tuple[Push, ...] = ()
    handles: tuple[Handle, ...] = ()
    fields: tuple[ForceField, ...] = ()
    initial_velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    initial_spin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    initial_pose: FloatArray | None = None
    body_friction: float = 0.5
    self_contact: bool = False

    def __post_init__(self) -> None:
        """Check names, numbers, and that every push names a region."""
        checks.instance("Scene.character", self.character, Character)
        checks.keep(
            self,
            others=checks.items("Scene.others", self.others, Body),
            ground=None if self.ground is None else checked_ground("Scene.ground", self.ground),
            gravity=checks.vector("Scene.gravity", self.gravity, unit="m/s^2"),
            pushes=checks.items("Scene.pushes", self.pushes, Push),
            handles=checks.items("Scene.handles", self.handles, Handle),
            fields=checks.items("Scene.fields", self.fields, ForceField),  # type: ignore[type-abstract]
            initial_velocity=checks.vector(
                "Scene.initial_velocity", self.initial_velocity, unit="m/s"
            ),
            initial_spin=checks.vector("Scene.initial_spin", self.initial_spin, unit="rad/s"),
            initial_pose=checked_pose("Scene.initial_pose", self.initial_pose, self.character),
            body_friction=checks.number("Scene.body_friction", self.body_friction, low=0.0),
            self_contact=checks.truth("Scene.self_contact", self.self_contact),
        )
        input_kinds.distinct("bodies of the scene", (body.name for body in self.characters))
        for push in self.pushes:
            pushed_nodes(push.region, self.whole)
        for field in self.fields:
            if field.region is not None:
                acted_on(field.region, self.whole, self.parts)
        # asked for once, so that a wrong region is told of here
        _ = self.handle_nodes

    @property
    def characters(self) -> tuple[Character, ...]:
        """All bodies, the character first."""
        return (self.character, *(body.character for body in self.others))

    @cached_property
    def whole(self) -> Character:
        """All bodies joined, as the engine sees them; the character's nodes come first."""
        return join(self.characters)

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The ranges of each body in the joined arrays."""
        return parts_of(self.characters)

    @cached_property
    def node_bodies(self) -> npt.NDArray[np.int32]:
        """(n,) number of each node's body in `parts`."""
        counts = [part.nodes.stop - part.nodes.start for part in self.parts]
        return np.repeat(np.arange(len(counts), dtype=np.int32), counts)

    @cached_property
    def handle_nodes(self) -> tuple[npt.NDArray[np.int32], ...]:
        """The nodes (k,) that each handle moves."""
        return nodes_of_handles(self.handles, self.whole, self.parts)

    @cached_property
    def held(self) -> npt.NDArray[np.int32]:
        """(k,) the nodes that contact and forces do not move: fixed ones, and those of handles."""
        return np.unique(np.concatenate([self.whole.fixed, *self.handle_nodes])).astype(np.int32)

    @cached_property
    def let_go(self) -> npt.NDArray[np.int32]:
        """(k,) those of them that handles let go at some time."""
        handles = zip(self.handles, self.handle_nodes, strict=True)
        nodes = [nodes for handle, nodes in handles if handle.until is not None]
        return np.concatenate([np.zeros(0, np.int32), *nodes])

    @property
    def start_points(self) -> FloatArray:
        """Where all nodes (n, 3) m are at the start, but for what handles move."""
        poses = (self.initial_pose, *(body.pose for body in self.others))
        points = np.array(self.whole.mesh.points)
        for part, pose in zip(self.parts, poses, strict=True):
            if pose is not None:
                points[part.nodes] = pose
        return points

    @property
    def starts(self) -> tuple[tuple[Vector, Vector], ...]:
        """Velocity, m/s, and spin, rad/s, of each body at the start, in the order of `parts`."""
        others = ((body.velocity, body.spin) for body in self.others)
        return ((self.initial_velocity, self.initial_spin), *others)

    @property
    def has_region_materials(self) -> bool:
        """Whether a body is stiffer or denser in some regions than elsewhere."""
        return any(character.materials for character in self.characters)

    @cached_property
    def elastic_volumes(self) -> npt.NDArray[np.float64]:
        """(m,) m^3, volumes of all tets times their stiffness over that of their body's material.

        Elastic forces, energies and stiffness are linear in it.
        """
        if not self.has_region_materials:
            return self.whole.mesh.volumes
        factors = [character.tet_materials.stiffness for character in self.characters]
        return np.asarray(self.whole.mesh.volumes * np.concatenate(factors))

    @property
    def has_pairs(self) -> bool:
        """Whether surfaces may touch each other."""
        return self.self_contact or bool(self.others)

    @cached_property
    def has_ground_edges(self) -> bool:
        """Whether the ground has sharp edges that may meet bodies between their nodes."""
        return isinstance(self.ground, HeightField) and bool(self.ground.creases.any())
