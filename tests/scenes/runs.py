"""A run of a shipped scene by the command, read back from its stage."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.motions.criteria import examine
from benchmarks.motions.criterion import RecordedMotion
from warp_softbody import scenes
from warp_softbody.cli import main
from warp_softbody.stage_exports import validate

Shipped = Callable[[str], RecordedMotion]
"""Makes the motion of a scene as it is shipped."""


def run(
    scene: str, folder: Path, *options: str, volume: float = 0.05, code: int = 0
) -> RecordedMotion:
    """A run's motion; its stage is valid and finite, without inverted or sunken tets.

    The volume of the body may change by the share given; the paper's by 0.15. The command ends with
    an exit code.
    """
    stage = folder / f"{scene}.usdc"
    line = ["run", scene, "--out", str(stage), "--fps", "60", "--quiet", *options]
    assert main(line) == code
    assert validate(stage) == []
    motion = RecordedMotion.read(stage, scenes.make(scene).scene.character)
    measures = motion.measures
    assert measures.finite.all()
    assert measures.smallest_volume_ratio.min() > 0.0
    assert np.abs(measures.volume_change).max() < volume
    assert measures.penetration.max() < 0.002
    return motion


def missed(scene: str, motion: RecordedMotion) -> list[str]:
    """What is asked of the scene and not met, each with its number."""
    return [str(finding) for finding in examine(scene, motion) if not finding.holds]
