"""A stage that is written while a page drives the scene."""

from __future__ import annotations

from pathlib import Path

from warp_softbody.stage_exports.usd.writer import StageWriter
from warp_softbody.world.frame import Frame
from warp_softbody.world.scene import Scene

MOST_FILES = 10_000


class StageRecording:
    """Writes frames into a new file of a folder.

    Attributes:
        path: of the stage.
    """

    def __init__(self, folder: Path, name: str, scene: Scene, fps: float) -> None:
        """Begin a stage beside those that are there.

        Raises:
            OutputError: it cannot be written.
        """
        numbered = (folder / f"{name}-live-{number}.usdc" for number in range(1, MOST_FILES))
        self.path = next(path for path in numbered if not path.exists())
        metadata = {"scene": name, "driven": "by hand"}
        self._writer = StageWriter(self.path, scene, fps=fps, overwrite=False, metadata=metadata)
        self._frames = 0

    def write(self, frame: Frame) -> None:
        """Add a frame, later than the last one.

        Raises:
            OutputError: it could not be written.
        """
        self._writer.write(frame)
        self._frames += 1

    def close(self) -> str:
        """Finish the file; return what became of it.

        Raises:
            OutputError: it could not be written.
        """
        self._writer.close()
        if not self._frames:
            return "nothing was recorded"
        return f"{self.path.name}: {self._frames} frames"
