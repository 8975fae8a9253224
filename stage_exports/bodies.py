"""Each body of a scene has its share of the arrays that a frame holds for all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks
from warp_softbody.inputs.records import unchecked_copy
from warp_softbody.stage_exports.layout import Layout
from warp_softbody.world.frame import ContactSample, Frame
from warp_softbody.world.scene import Scene


@dataclass(frozen=True, kw_only=True)
class StagedBody:
    """A body and where it stands in a frame.

    Attributes:
        character: the body.
        layout: its index sets, in its own numbers.
        number: its place among the bodies.
        starts: the first rows of all bodies in Frame.positions.
        nodes: its rows of Frame.positions.
        segments: its rows of Frame.activations.
        vertices: its rows of Frame.fiber_points.
        touches: whether there is anything that it could touch.
        plans: whether a controller could plan contacts for it.
        alone: whether all of a frame is its own.
    """

    character: Character
    layout: Layout
    number: int
    starts: tuple[int, ...]
    nodes: slice
    segments: slice
    vertices: slice
    touches: bool
    plans: bool
    alone: bool

    @cached_property
    def size(self) -> float:
        """Diagonal of the box at rest, m."""
        return float(np.linalg.norm(np.ptp(self.character.mesh.points, axis=0)))

    def share(self, frame: Frame) -> Frame:
        """The frame as if there were no other body."""
        if self.alone:
            return frame
        return unchecked_copy(
            frame,
            positions=frame.positions[self.nodes],
            velocities=frame.velocities[self.nodes],
            activations=frame.activations[self.segments],
            fiber_points=frame.fiber_points[self.vertices],
            contacts=self._own(frame),
            patches=frame.patches if self.plans else ContactSample(),
        )

    def _own(self, frame: Frame) -> ContactSample:
        """All that acts on its nodes, in its own numbers and those of the bodies on other sides."""
        bodies = np.searchsorted(self.starts, frame.contacts.nodes, side="right") - 1
        contacts = unchecked_copy(frame.contacts, bodies=bodies.astype(np.int32))
        contacts = contacts.seen_by(self.number, frame.positions)
        others = contacts.partner_nodes
        starts = np.array(self.starts, dtype=np.int32)[contacts.partners][:, None]
        return unchecked_copy(
            contacts,
            nodes=contacts.nodes - self.nodes.start,
            partner_nodes=np.where(others >= 0, others - starts, others),
        )


def check_fits(frame: Frame, bodies: Sequence[StagedBody]) -> None:
    """Refuse a frame of other bodies, or one that cannot be drawn."""
    last = bodies[-1]
    for name, rows in (
        ("positions", last.nodes.stop),
        ("activations", last.segments.stop),
        ("fiber_points", last.vertices.stop),
    ):
        array = getattr(frame, name)
        if len(array) != rows:
            raise InputError(
                f"frame {frame.index}: {name} must have {rows} rows for this scene, "
                f"not {len(array)}"
            )
        array_checks.array(f"frame {frame.index}: {name}", array, None)


def staged_bodies(scene: Scene) -> tuple[StagedBody, ...]:
    """All bodies of a scene, the character first."""
    bodies: list[StagedBody] = []
    vertices = 0
    starts = tuple(part.nodes.start for part in scene.parts)
    for character, part in zip(scene.characters, scene.parts, strict=True):
        layout = Layout.of(character)
        start, vertices = vertices, vertices + len(layout.fiber_vertices)
        bodies.append(
            StagedBody(
                character=character,
                layout=layout,
                number=len(bodies),
                starts=starts,
                nodes=part.nodes,
                segments=part.segments,
                vertices=slice(start, vertices),
                touches=scene.ground is not None or scene.has_pairs,
                plans=not bodies and scene.ground is not None and character.segment_count > 0,
                alone=not scene.others,
            )
        )
    return tuple(bodies)


def rest_frame(bodies: Sequence[StagedBody]) -> Frame:
    """All bodies at rest, their muscles slack, in touch with nothing."""
    points = np.concatenate([body.character.mesh.points for body in bodies])
    return Frame(
        index=0,
        time=0.0,
        positions=points,
        velocities=np.zeros(points.shape),
        activations=np.ones(bodies[-1].segments.stop),
        fiber_points=np.concatenate([body.layout.fiber_vertices for body in bodies]),
        contacts=ContactSample(),
    )
