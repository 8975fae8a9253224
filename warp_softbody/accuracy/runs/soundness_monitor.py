"""Watches a run for what frames of 1/30 s are too far apart to show: volume, and shaking."""

from __future__ import annotations

import numpy as np

from warp_softbody.accuracy.cases.track import Soundness
from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh_geometry import tet_volumes
from warp_softbody.world.scene import Scene
from warp_softbody.world.view import BodyView

FPS = 60.0
"""Frames a second at most: every step where steps are longer."""

ROUNDING = 1e-5
"""m/s between two frames: smaller changes of a velocity are none, as a body at rest has them."""


class SoundnessMonitor:
    """Keeps the largest change of volume, and counts accelerations that turn."""

    def __init__(self, scene: Scene) -> None:
        """Nothing was seen yet."""
        mesh = scene.whole.mesh
        self._tets, self._rest = mesh.tets, float(tet_volumes(mesh.points, mesh.tets).sum())
        self._volume = 0.0
        self._velocities: FloatArray | None = None
        self._change: FloatArray | None = None
        self._turned = self._count = 0

    def see(self, view: BodyView) -> None:
        """Take in the next frame."""
        volume = float(tet_volumes(view.positions, self._tets).sum())
        self._volume = max(self._volume, abs(volume / self._rest - 1.0))
        before, velocities = self._velocities, np.array(view.velocities)
        self._velocities = velocities
        if before is None:
            return
        change = velocities - before
        change[np.linalg.norm(change, axis=1) < ROUNDING] = 0.0
        if self._change is not None:
            self._turned += int(((change * self._change).sum(axis=1) < 0.0).sum())
            self._count += len(change)
        self._change = change

    def seen(self) -> Soundness:
        """What was seen so far."""
        return Soundness(volume=self._volume, reversals=self._turned / max(1, self._count))
