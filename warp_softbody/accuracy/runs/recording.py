"""Gathers the frames of a run and makes of them what is kept."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warp_softbody.accuracy.cases.functionals import FUNCTIONALS
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.cases.track import MaterialPointTracker, Track, material_points
from warp_softbody.accuracy.runs.job import Job
from warp_softbody.accuracy.runs.soundness_monitor import SoundnessMonitor
from warp_softbody.arrays import FloatArray
from warp_softbody.world.scene import Scene
from warp_softbody.world.view import BodyView


class Recording:
    """Frames of a run on any mesh, and the same material points on all of them."""

    def __init__(self, job: Job, scene: Scene, masses: FloatArray) -> None:
        """Find the material points, which are nodes of the scene's usual mesh whatever is run."""
        own = Settings(time_step=job.settings.time_step).plan(job.scene, job.given).scene
        self._probe = MaterialPointTracker(scene, material_points(own))
        self._names = job.functionals
        self._scene = scene
        self._masses = masses
        self._times: list[float] = []
        self._frames: list[FloatArray] = []
        watched = any(FUNCTIONALS[name].limit is not None for name in job.functionals)
        self._monitor = SoundnessMonitor(scene) if watched else None

    def add(self, time: float, positions: FloatArray) -> None:
        """Keep a frame."""
        self._times.append(time)
        self._frames.append(positions)

    def see(self, view: BodyView) -> None:
        """Look at a step, where anything is measured that frames are too far apart to show."""
        if self._monitor is not None:
            self._monitor.see(view)

    def functionals(self) -> dict[str, float]:
        """Values of those asked for."""
        track = Track(
            scene=self._scene,
            times=np.array(self._times),
            points=np.stack(self._frames),
            masses=self._masses,
            **({} if self._monitor is None else {"soundness": self._monitor.seen()}),
        )
        return {name: FUNCTIONALS[name].of(track) for name in self._names}

    def path(self) -> npt.NDArray[np.float32]:
        """(f, k, 3) m; rounded to single precision, some 1e-7 of the body's size."""
        return np.stack([self._probe(frame) for frame in self._frames]).astype(np.float32)
