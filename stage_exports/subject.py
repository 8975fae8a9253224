"""What a picture shows, whether it comes from a running scene or from a stage read back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_softbody.frame import Frame
from warp_softbody.ground import Ground
from warp_softbody.scene import Scene
from warp_softbody.stage_exports.conventions import FloatArray, IntArray
from warp_softbody.stage_exports.layout import Layout
from warp_softbody.stage_exports.reader import Take


@dataclass(frozen=True, kw_only=True)
class Subject:
    """The part of a picture that no frame changes.

    Attributes:
        rest: (k, 3) m, skin points at rest.
        faces: (f, 3) outward triangles of the skin.
        color: linear RGB.
        ground: what it moves on, or None.
    """

    rest: FloatArray
    faces: IntArray
    color: tuple[float, float, float]
    ground: Ground | None

    @property
    def size(self) -> float:
        """Diagonal of the box at rest, m: the length that all drawn sizes are parts of."""
        return float(np.linalg.norm(np.ptp(self.rest, axis=0)))

    @classmethod
    def of_scene(cls, scene: Scene, layout: Layout) -> Subject:
        """The character of a scene."""
        return cls(
            rest=np.asarray(scene.character.mesh.points[layout.skin_nodes]),
            faces=layout.skin_faces,
            color=scene.character.color,
            ground=scene.ground,
        )

    @classmethod
    def of_take(cls, take: Take) -> Subject:
        """The character of a stage."""
        return cls(rest=take.skin_rest, faces=take.skin_faces, color=take.color, ground=take.ground)


@dataclass(frozen=True, kw_only=True)
class Pose:
    """The part that a frame changes.

    Attributes:
        skin: (k, 3) m.
        segments: (s, 2, 3) m, ends of the muscle segments.
        activations: (s,) l_d / l_0.
    """

    skin: FloatArray
    segments: FloatArray
    activations: FloatArray

    @classmethod
    def of_frame(cls, frame: Frame, layout: Layout) -> Pose:
        """The pose of a running scene."""
        return cls(
            skin=frame.positions[layout.skin_nodes],
            segments=frame.fiber_points[layout.segment_ends],
            activations=frame.activations,
        )

    @classmethod
    def of_take(cls, take: Take, index: int) -> Pose:
        """A frame of a stage."""
        return cls(
            skin=take.skin_points[index],
            segments=take.fiber_points[index],
            activations=take.activations[index],
        )
