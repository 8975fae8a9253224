"""What a search of gains measures of a run, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh_geometry import tet_volumes
from warp_softbody.engine.model import Model
from warp_softbody.world.frame import Frame
from warp_softbody.world.scene import Scene

CLEAR = 1e-3
"""m above the ground from which a body counts as in the air."""

LYING = 0.62
"""Share of the first height of the centre of mass: a letter on its side has 0.59, one that crouches
before it jumps 0.65."""

LAST = 0.5
"""s at the end of a run over which rest is measured."""


@dataclass(kw_only=True)
class Record:
    """The frames of a run that are kept, and what is reckoned from each."""

    scene: Scene
    masses: FloatArray
    fps: float
    positions: list[FloatArray] = field(default_factory=list)
    velocities: list[FloatArray] = field(default_factory=list)

    @classmethod
    def of(cls, model: Model, fps: float) -> Record:
        """An empty record of a run of the model's character."""
        return cls(scene=model.scene, masses=model.masses / model.masses.sum(), fps=fps)

    def add(self, frame: Frame) -> None:
        """Keep a frame."""
        self.positions.append(frame.positions)
        self.velocities.append(frame.velocities)

    @property
    def fallen(self) -> bool:
        """Whether the centre of mass is as low now as that of a body that lies."""
        first, now = (self.masses @ self.positions[k][:, 2] for k in (0, -1))
        return bool(now < LYING * first)

    def measures(self) -> dict[str, float]:
        """Every measure of the run, by name; SI units and degrees."""
        points, velocities = np.array(self.positions), np.array(self.velocities)
        middle = np.asarray(self.masses @ points)
        last = max(1, round(LAST * self.fps))
        found = {
            "seconds": (len(points) - 1) / self.fps,
            "height": float(middle[-1, 2] / middle[0, 2]),
            "sideways": float(np.abs(middle[:, 1] - middle[0, 1]).max()),
            "speed": float(np.linalg.norm(velocities[-last:], axis=2).max()),
            "sign_changes": sign_changes(velocities),
        }
        found |= self._volumes(points) | self._turning(points) | self._air(points)
        return found | self._base(points)

    def _volumes(self, points: FloatArray) -> dict[str, float]:
        mesh = self.scene.character.mesh
        rest = tet_volumes(mesh.points, mesh.tets)
        ratios = np.array([tet_volumes(frame, mesh.tets) / rest for frame in points])
        totals = ratios @ rest / rest.sum()
        return {
            "volume_change": float(np.abs(totals - 1.0).max()),
            "smallest_tet": float(ratios.min()),
        }

    def _turning(self, points: FloatArray) -> dict[str, float]:
        turns = rotations(self.masses, self.scene.character.mesh.points, points)
        tilt = np.degrees(np.arctan2(np.hypot(*turns[:, :2, 2].T), turns[:, 2, 2]))
        sine, cosine = turns[:, 0, 2] - turns[:, 2, 0], turns[:, 0, 0] + turns[:, 2, 2]
        rolled = np.unwrap(np.arctan2(sine, cosine))
        rolled = np.degrees(rolled - rolled[0])
        self._yaw = np.degrees(
            np.unwrap(np.arctan2(turns[:, 1, 0] - turns[:, 0, 1], turns[:, 0, 0] + turns[:, 1, 1]))
        )
        return {
            "tilt": float(tilt[-1]),
            "largest_tilt": float(tilt.max()),
            "rolled": float(rolled.max()),
            "rolled_back": float(rolled.max() - rolled[int(rolled.argmax()) :].min()),
        }

    def _air(self, points: FloatArray) -> dict[str, float]:
        ground = self.scene.ground
        assert ground is not None
        surface = self.scene.character.mesh.surface_nodes
        lowest = np.array([ground.measure(frame[surface])[0].min() for frame in points])
        edges = np.diff(np.concatenate([[False], lowest > CLEAR, [False]]).astype(int))
        begins, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
        seconds = (ends - begins) / self.fps
        longest = int(seconds.argmax()) if len(seconds) else -1
        turned = self._yaw[ends[longest] - 1] - self._yaw[begins[longest]] if longest >= 0 else 0.0
        return {
            "air": float(seconds.max(initial=0.0)),
            "jumps": float((seconds >= 0.15).sum()),
            "yaw_in_air": float(abs(turned)),
            "penetration": float(max(0.0, -lowest.min())),
        }

    def _base(self, points: FloatArray) -> dict[str, float]:
        character = self.scene.character
        if "base" not in character.regions:
            return {}
        nodes = character.region("base")
        faces = character.mesh.surface
        faces = faces[np.isin(faces, nodes).all(axis=1)]
        flat = points[:, :, :2][:, faces]
        a, b = flat[:, :, 1] - flat[:, :, 0], flat[:, :, 2] - flat[:, :, 0]
        areas = np.abs(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]).sum(axis=1)
        base = points[:, nodes]
        return {
            "way": float(base[-1, :, 0].mean() - base[0, :, 0].mean()),
            "base_growth": float(areas.max() / areas[0] - 1.0),
            "lifted": float((base[:, :, 2] > CLEAR).mean(axis=1).max()),
        }


def sign_changes(velocities: FloatArray) -> float:
    """Share of the nodes' accelerations that change sign from one frame to the next."""
    accelerations = np.diff(velocities, axis=0)
    return float((accelerations[1:] * accelerations[:-1] < 0.0).mean())


def rotations(masses: FloatArray, rest: FloatArray, points: FloatArray) -> FloatArray:
    """(f, 3, 3): the rotation that takes the rest shape nearest to each frame."""
    moved = points - (masses @ points)[:, None]
    moments = np.einsum("fni,nj->fij", moved, masses[:, None] * (rest - masses @ rest))
    left, _, right = np.linalg.svd(moments)
    left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
    return np.asarray(left @ right)
