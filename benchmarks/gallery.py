"""The pictures of the pages, made anew: ``python -m benchmarks.gallery``.

Every controlled scene is run at its full length and drawn as a strip of frames, the characters are
drawn at rest. Names choose some of them: ``python -m benchmarks.gallery walk-x letter_x``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.motions.command import controlled
from warp_softbody import Plane, Scene, Simulation, StageWriter, characters, scenes
from warp_softbody.stage_exports import draw_frame, draw_take

README_SCENE, README_SECONDS = "balance-i", 2.0
"""The README shows the push alone."""

WITH_SETTINGS = {
    "balance-i-hops": ("balance-i", {"push": 0.65}, 2.2),
    "leap-i-three": ("leap-i", {"leaps": 3.0}, 2.2),
    "balance-i-falls": ("balance-i", {"push": 0.8}, 1.4),
    "walk-x-mixed": (
        "walk-x",
        {
            "slope": 6.0,
            "roughness": 0.05,
            "steps": 0.05,
            "friction_stripes": 0.5,
            "ground_seed": 3,
        },
        20.0,
    ),
}
"""Strips of a scene with settings, and how many seconds of it they show."""

FLAT = ("letter_x", "letter_i_flat")
"""Characters that are drawn from above too."""


def strip(name: str, docs: Path, folder: Path) -> Path:
    """A scene as a strip of frames."""
    scene, settings, seconds = WITH_SETTINGS.get(name, (name, {}, None))
    plan = scenes.make(scene, settings)
    readme = name == README_SCENE
    stage = folder / f"{name}.usdc"
    simulation = Simulation(plan.scene, plan.controller, time_step=plan.time_step)
    with StageWriter(stage, plan.scene) as writer:
        for frame in simulation.run(README_SECONDS if readme else seconds or plan.seconds):
            writer.write(frame)
    if readme:
        return draw_take(docs / f"images/{name}.png", stage, count=6, columns=6, size=(260, 300))
    return draw_take(docs / f"gallery/{name}.png", stage, count=12, columns=6, size=(260, 240))


def portraits(name: str, docs: Path, folder: Path) -> list[Path]:
    """A character at rest, a flat one from above too."""
    scene = Scene(character=characters.make(name), ground=Plane())
    stage = folder / f"{name}.usdc"
    with StageWriter(stage, scene) as writer:
        writer.write(Simulation(scene).frame())
    pictures = docs / "images/characters"
    made = [draw_frame(pictures / f"{name}.png", stage, size=(480, 420), camera="still")]
    if name in FLAT:
        points = np.asarray(scene.character.mesh.points)
        low, high = points.min(axis=0), points.max(axis=0)
        size = float(np.linalg.norm(high - low))
        above = (low + high) / 2.0 + size * np.array([0.6, -1.2, 2.0])
        eye = (float(above[0]), float(above[1]), float(above[2]))
        path = pictures / f"{name}_above.png"
        made.append(draw_frame(path, stage, size=(480, 420), camera=eye))
    return made


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw what was asked for, everything without a name."""
    known = [*controlled(), *WITH_SETTINGS, "stack", *characters.names()]
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="scenes and characters")
    parser.add_argument("--docs", type=Path, default=Path("docs"), help="folder of the pages")
    given = parser.parse_args(arguments)
    unknown = sorted(set(given.names) - set(known))
    if unknown:
        parser.error(f"no picture is made of {unknown[0]!r}; there are {', '.join(known)}")
    with TemporaryDirectory() as folder:
        for name in given.names or known:
            if name in characters.names():
                made = portraits(name, given.docs, Path(folder))
            else:
                made = [strip(name, given.docs, Path(folder))]
            print(*made, sep="\n", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
