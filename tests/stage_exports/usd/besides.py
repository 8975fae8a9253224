"""Runs with a writer beside them, in processes that have one thread, as a command line has."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tests.support.processes import start_python
from warp_softbody.body.character import Character
from warp_softbody.body.mesh import TetMesh
from warp_softbody.errors import SoftBodyError
from warp_softbody.stage_exports.usd import beside, forking
from warp_softbody.world.frame import ContactSample, Frame
from warp_softbody.world.scene import Scene


class Done(NamedTuple):
    """How a process ended."""

    code: int
    out: str
    err: str


def in_a_process(folder: Path, *cases: str) -> Done:
    """Run cases of those below, each in a folder of its name."""
    process = start_python(
        "-m",
        "tests.stage_exports.usd.besides",
        folder,
        *cases,
        environment={"OPENBLAS_NUM_THREADS": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    out, err = process.communicate(timeout=60)
    return Done(process.returncode, out, err)


def tet() -> Scene:
    """One tet."""
    mesh = TetMesh.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3]])
    return Scene(character=Character(name="tet", mesh=mesh))


def frames(count: int) -> Iterator[Frame]:
    """Frames that differ from one another."""
    rng = np.random.default_rng(1)
    for index in range(count):
        yield Frame(
            index=index,
            time=index / 30,
            positions=rng.random((4, 3)),
            velocities=rng.random((4, 3)),
            activations=np.zeros(0),
            fiber_points=np.zeros((0, 3)),
            contacts=ContactSample(),
        )


def write(writer: Any, given: Iterator[Frame]) -> None:
    """All frames, in a `with` body."""
    with writer as stage:
        for frame in given:
            stage.write(frame)


def spoilt(name: str, value: Any) -> Iterator[Frame]:
    """Frames of which the eighth is wrong."""
    for frame in frames(200):
        if frame.index == 7:
            object.__setattr__(frame, name, value)
        yield frame


def told(case: str, path: Path) -> None:
    """Cases that end in a sentence."""
    scene = tet()
    if case == "not finite":
        write(beside.stage_writer(path, scene), spoilt("velocities", np.full((4, 3), np.nan)))
    elif case == "last not finite":
        # of which the run hears at the end
        write(
            beside.stage_writer(path, scene),
            islice(spoilt("velocities", np.full((4, 3), np.nan)), 8),
        )
    elif case == "not later":
        write(beside.stage_writer(path, scene), spoilt("time", 6 / 30))
    elif case == "bad metadata":
        metadata: Any = {"when": object}
        write(beside.stage_writer(path, scene, metadata=metadata), frames(3))
    elif case == "full disk":
        # each chunk fits, the stage does not
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (480_000, 480_000))
        write(beside.stage_writer(path, scene), frames(3000))
    elif case == "killed":
        with beside.stage_writer(path, scene) as stage:
            assert isinstance(stage, beside.StageBeside)
            os.kill(stage._process, signal.SIGKILL)
            for frame in frames(2000):
                stage.write(frame)
    else:
        stage = beside.stage_writer(path, scene)
        write(stage, frames(3))
        stage.close()
        stage.write(next(frames(1)))


def left(case: str, path: Path) -> None:
    """Cases in which nobody waits for the stage, or the writer is stopped while it closes it."""
    serve = forking._serve

    def stopping(*arguments: Any) -> None:
        from warp_softbody.stage_exports.usd.growing_crate import GrowingCrate

        def stop(_: GrowingCrate) -> None:
            os.kill(os.getpid(), forking.STOP)

        GrowingCrate.finish = stop  # type: ignore[assignment, method-assign]
        serve(*arguments)

    if case == "stopped":
        forking._serve = stopping  # type: ignore[assignment]
    stage = beside.stage_writer(path, tet()).__enter__()
    forking._serve = serve
    for frame in frames(48):
        stage.write(frame)
    if case == "dies":
        os.kill(os.getpid(), signal.SIGKILL)
    elif case == "stopped":
        stage.close()


def run(case: str, path: Path) -> None:
    """Run a case."""
    if case.startswith("same"):
        sizes = {"same": 16 << 20, "same, waiting": 2000, "same, large": 100}
        beside.LEAST_RING, beside.FRAMES_AHEAD = sizes[case], 0
        write(beside.stage_writer(path, tet()), frames(300))
        beside.LEAST_RING, beside.FRAMES_AHEAD = sizes["same"], 8
    elif case == "nothing":
        write(beside.stage_writer(path, tet()), frames(0))
    elif case in ("dropped", "dies", "stopped"):
        left(case, path)
    else:
        told(case, path)


def main(folder: str, *cases: str) -> None:
    """Run cases and print the sentence in which each ends."""
    for case in cases:
        path = Path(folder) / case / "beside.usdc"
        path.parent.mkdir()
        sentence = ""
        try:
            run(case, path)
        except SoftBodyError as error:
            sentence = f"{type(error).__name__}: {error}"
        print(f"{case}\t{sentence}", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
