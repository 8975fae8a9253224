"""A picture shows a `Subject`, made of a running scene or of a stage that is read back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.skin import Skin
from warp_softbody.stage_exports.bodies import StagedBody, check_fits
from warp_softbody.stage_exports.conventions import IntArray
from warp_softbody.stage_exports.usd.reader import Take
from warp_softbody.world.frame import Frame
from warp_softbody.world.ground import Ground


class Shape(NamedTuple):
    """One body: skin points (k, 3) at rest, faces (f, 3), linear RGB, segments, own skin."""

    rest: FloatArray
    faces: IntArray
    color: tuple[float, float, float]
    segments: int
    skin: Skin | None


@dataclass(frozen=True, kw_only=True)
class Subject:
    """The part of a picture that no frame changes: all bodies, one after the other.

    Attributes:
        rest: (k, 3) m, skin points at rest.
        faces: (f, 3) outward triangles of the skins.
        face_bodies: (f,) which body a face belongs to.
        segment_bodies: (s,) which body a muscle segment belongs to.
        skins: of each body, where it has one of its own, which tells its colours.
        colors: (b, 3) linear RGB of each body.
        sizes: (b,) m, diagonal of each body's box at rest, which drawn sizes are parts of.
        ground: what they move on, or None.
    """

    rest: FloatArray
    faces: IntArray
    face_bodies: IntArray
    segment_bodies: IntArray
    skins: tuple[Skin | None, ...]
    colors: FloatArray
    sizes: FloatArray
    ground: Ground | None

    @property
    def size(self) -> float:
        """Diagonal of the largest body, m."""
        return float(self.sizes.max())

    @classmethod
    def of_bodies(cls, bodies: Sequence[StagedBody], ground: Ground | None) -> Subject:
        """All bodies of a scene."""
        shapes = [
            Shape(
                body.layout.skin_at(np.asarray(body.character.mesh.points)),
                body.layout.skin_faces,
                body.character.color,
                len(body.layout.segment_ends),
                body.character.skin,
            )
            for body in bodies
        ]
        return cls.of_shapes(shapes, ground)

    @classmethod
    def of_takes(cls, takes: Sequence[Take]) -> Subject:
        """Bodies of one stage."""
        shapes = [
            Shape(take.skin_rest, take.skin_faces, take.color, take.activations.shape[1], take.skin)
            for take in takes
        ]
        return cls.of_shapes(shapes, takes[0].ground)

    @classmethod
    def of_shapes(cls, shapes: Sequence[Shape], ground: Ground | None) -> Subject:
        """Bodies joined into one surface."""
        number = np.arange(len(shapes), dtype=np.int32)
        starts = np.cumsum([0, *(len(shape.rest) for shape in shapes)])
        faces = [
            shape.faces + np.int32(start) for shape, start in zip(shapes, starts[:-1], strict=True)
        ]
        return cls(
            rest=np.concatenate([shape.rest for shape in shapes]),
            faces=np.concatenate(faces),
            face_bodies=np.repeat(number, [len(shape.faces) for shape in shapes]),
            segment_bodies=np.repeat(number, [shape.segments for shape in shapes]),
            skins=tuple(shape.skin for shape in shapes),
            colors=np.array([shape.color for shape in shapes]),
            sizes=np.linalg.norm([np.ptp(shape.rest, axis=0) for shape in shapes], axis=1),
            ground=ground,
        )


@dataclass(frozen=True, kw_only=True)
class Pose:
    """The part that a frame changes, in the order of the subject.

    Attributes:
        skin: (k, 3) m.
        segments: (s, 2, 3) m, ends of the muscle segments.
        activations: (s,) l_d / l_0.
    """

    skin: FloatArray
    segments: FloatArray
    activations: FloatArray

    @classmethod
    def of_frame(cls, frame: Frame, bodies: Sequence[StagedBody]) -> Pose:
        """The pose of a running scene."""
        check_fits(frame, bodies)
        ends = [body.layout.segment_ends + body.vertices.start for body in bodies]
        return cls(
            skin=np.concatenate(
                [body.layout.skin_at(frame.positions[body.nodes]) for body in bodies]
            ),
            segments=frame.fiber_points[np.concatenate(ends)],
            activations=frame.activations,
        )

    @classmethod
    def of_takes(cls, takes: Sequence[Take], index: int) -> Pose:
        """A frame of a stage."""
        return cls(
            skin=np.concatenate([take.skin_points[index] for take in takes]),
            segments=np.concatenate([take.fiber_points[index] for take in takes]),
            activations=np.concatenate([take.activations[index] for take in takes]),
        )
