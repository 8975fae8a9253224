"""Bytes, time and memory of long stages: `python -m benchmarks.stage_export walk-x --frames 4000`.

A body sways, so that no frame is like another, while its muscles work and its lowest nodes touch.
Times are CPU seconds of this process.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.tables import as_text
from warp_softbody import scenes
from warp_softbody.stage_exports import StageWriter
from warp_softbody.stage_exports.bodies import staged_bodies
from warp_softbody.world.frame import ContactSample, Frame
from warp_softbody.world.scene import Scene

TOUCHING = 20
PARTS = 4


def swaying(scene: Scene, index: int, fps: float) -> Frame:
    """A frame of the whole scene."""
    whole, time_ = scene.whole, index / fps
    swing = np.array([np.sin(1.7 * time_), np.sin(2.3 * time_), 0.3 * np.sin(3.1 * time_)])
    rate = np.array(
        [1.7 * np.cos(1.7 * time_), 2.3 * np.cos(2.3 * time_), 0.93 * np.cos(3.1 * time_)]
    )
    points = np.asarray(whole.mesh.points)
    lever = 0.2 * points[:, 2:] ** 2
    lowest = np.argsort(points[:, 2], kind="stable")[:TOUCHING].astype(np.int32)
    vertices = np.concatenate([np.zeros((0, 3)), *(fiber.vertices for fiber in whole.fibers)])
    noise = np.sin(np.arange(whole.segment_count) + 5.0 * time_)
    return Frame(
        index=index,
        time=time_,
        positions=points + lever * swing,
        velocities=lever * rate,
        activations=0.75 + 0.25 * noise,
        fiber_points=vertices + 0.2 * vertices[:, 2:] ** 2 * swing,
        contacts=ContactSample(
            nodes=lowest,
            points=points[lowest] + lever[lowest] * swing,
            modes=np.ones(TOUCHING, dtype=np.int32),
            forces=np.outer(1.0 + np.arange(TOUCHING), [0.0, np.sin(time_), 10.0]),
            bodies=scene.node_bodies[lowest],
        ),
    )


class _Memory:
    """Watches this process for memory of its own: pages of mapped files can be let go.

    Attributes:
        most: so far, kB.
    """

    def __init__(self) -> None:
        self.most = 0
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def _watch(self) -> None:
        self._look()
        while not self._done.wait(0.05):
            self._look()

    def _look(self) -> None:
        lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
        anonymous = next(line for line in lines if line.startswith("RssAnon"))
        self.most = max(self.most, int(anonymous.split()[1]))

    def stop(self) -> None:
        """Watch no more."""
        self._done.set()
        self._thread.join()


def raw_bytes(scene: Scene) -> int:
    """Of a frame: positions of skins, tets, fibres and contacts, velocities, forces, in float32."""
    bodies = staged_bodies(scene)
    skin = sum(len(body.layout.skin_nodes) for body in bodies)
    ends = sum(2 * len(body.layout.segment_ends) for body in bodies)
    return 12 * (skin + 2 * len(scene.whole.mesh.points) + ends + 2 * TOUCHING)


def measured(name: str, frames: int, folder: Path) -> dict[str, Any]:
    """Write a stage of so many frames, and open it."""
    scene, fps = scenes.make(name).scene, 30.0
    path = folder / f"{name}.usdc"
    seconds = []
    memory = _Memory()
    with StageWriter(path, scene, fps=fps) as stage:
        for part in range(PARTS):
            spent = 0.0
            for index in range(part * frames // PARTS, (part + 1) * frames // PARTS):
                frame = swaying(scene, index, fps)
                begun = time.process_time()
                stage.write(frame)
                spent += time.process_time() - begun
            seconds.append(spent / (frames / PARTS))
        begun = time.process_time()
    closing = time.process_time() - begun
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    memory.stop()
    begun = time.process_time()
    _open(path)
    return {
        "scene": name,
        "frames": frames,
        "MB": f"{path.stat().st_size / 1e6:.1f}",
        "of raw": f"{path.stat().st_size / (raw_bytes(scene) * frames):.3f}",
        "ms a frame, by quarter": " ".join(f"{1e3 * s:.2f}" for s in seconds),
        "closing, ms a frame": f"{1e3 * closing / frames:.2f}",
        "peak, MB": f"{peak:.0f}",
        "without mapped files, MB": f"{memory.most / 1024:.0f}",
        "opening, s": f"{time.process_time() - begun:.2f}",
    }


def _open(path: Path) -> None:
    """Open a stage and ask for a skin in the middle of it, as a viewer does."""
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(path))
    middle = (stage.GetStartTimeCode() + stage.GetEndTimeCode()) / 2.0
    for prim in stage.Traverse():
        if prim.IsA(UsdGeom.PointBased):
            UsdGeom.PointBased(prim).GetPointsAttr().Get(middle)


def main() -> None:
    """Print one row a scene."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", default=["walk-x"])
    parser.add_argument("--frames", type=int, default=4000)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rows = [measured(name, given.frames, Path(folder)) for name in given.scenes]
    print(as_text(list(rows[0]), [row.values() for row in rows], left="scene"))


if __name__ == "__main__":
    main()
