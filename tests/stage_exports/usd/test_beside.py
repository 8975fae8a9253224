"""A writer in a process of its own: the same bytes, the same sentences, and nothing lost."""

from __future__ import annotations

import re
import signal
from collections import deque
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.stage_exports.usd.besides import frames, in_a_process, tet, write
from warp_softbody.stage_exports import StageWriter, read_take, recover, validate
from warp_softbody.stage_exports.usd.byte_ring import ByteRing
from warp_softbody.stage_exports.usd.frame_bytes import packed, unpacked
from warp_softbody.world.frame import Frame
from warp_softbody.world.scene import Scene


def same(one: Frame, other: Frame) -> bool:
    held = [
        (getattr(one, name), getattr(other, name))
        for name in ("positions", "velocities", "activations", "fiber_points")
    ]
    for kind in ("contacts", "patches"):
        first, second = getattr(one, kind), getattr(other, kind)
        held += [
            (getattr(first, name), getattr(second, name))
            for name in vars(first)
            if name != "names" and len(getattr(first, name))
        ]
    return (one.index, one.time) == (other.index, other.time) and all(
        a.dtype == b.dtype and np.array_equal(a, b) for a, b in held
    )


def test_a_frame_of_bytes_is_the_frame(scene: Scene, make_frames: Any) -> None:
    for frame in make_frames(scene, 5):
        assert same(frame, unpacked(memoryview(packed(frame))))


def test_arrays_of_other_kinds_and_orders_are_the_same_bytes(
    scene: Scene, make_frames: Any
) -> None:
    frame = list(make_frames(scene, 3))[-1]
    assert len(frame.contacts.points)
    wanted = packed(frame)
    for name in ("positions", "fiber_points"):
        values = getattr(frame, name)
        for other in (np.asfortranarray(values), np.repeat(values, 2, axis=0)[::2]):
            assert packed(replace(frame, **{name: other})) == wanted
    nodes = frame.contacts.nodes.astype(np.int64)
    contacts = replace(frame.contacts)
    object.__setattr__(contacts, "nodes", nodes)
    assert packed(replace(frame, contacts=contacts)) == wanted


def test_messages_stay_whole_until_they_are_read() -> None:
    ring, rng = ByteRing(1000), np.random.default_rng(3)
    waiting: deque[tuple[int, bytes]] = deque()
    refused = 0
    for _ in range(5000):
        message = rng.bytes(int(rng.integers(1, 300)))
        place = ring.put(message)
        if place is None:
            refused += 1
        else:
            waiting.append((place, message))
        for there, held in waiting:
            assert bytes(ring.view(there, len(held))) == held
        while waiting and (place is None or rng.random() < 0.4):
            ring.let_go(1)
            waiting.popleft()
            place = 0
    assert refused > 100
    assert ByteRing(1000).put(bytes(1001)) is None


def test_there_is_room_for_all_but_a_message() -> None:
    ring = ByteRing(1000)
    for _ in range(50):
        while ring.put(bytes(70)) is not None:
            pass
        ring.let_go(3)
        assert ring.put(bytes(70)) is not None and ring.put(bytes(70)) is not None


SENTENCES = {
    "same": "",
    "same, waiting": "",
    "same, large": "",
    "nothing": "",
    "not finite": "InputError: frame 7: velocities holds a number that is not finite",
    "last not finite": "InputError: frame 7: velocities holds a number that is not finite",
    "not later": "InputError: frame 7 at",
    "bad metadata": "InputError: metadata 'when'",
    "killed": "OutputError: .*the process that wrote it has ended",
    "closed": "OutputError: .*is closed; no frame can be added",
    "dropped": "",
    "stopped": "OutputError: .*the process that wrote it has ended",
    # after which this process can write no more
    "full disk": "OutputError: .*could not be written",
}
"""How a run of each case ends."""


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of all cases after all were run."""
    folder = tmp_path_factory.mktemp("beside")
    done = in_a_process(folder, *SENTENCES)
    told = dict(line.split("\t") for line in done.out.splitlines())
    assert (done.code, done.err, list(told)) == (0, "", list(SENTENCES)), done
    for case, sentence in SENTENCES.items():
        assert re.match(sentence or "$", told[case]), (case, told[case])
    return folder


@pytest.mark.parametrize("case", ["same", "same, waiting", "same, large"])
def test_the_stage_is_the_same_to_the_last_bit(runs: Path, tmp_path: Path, case: str) -> None:
    """Whether the writer keeps up, the run waits for it, or no frame fits into the memory."""
    write(StageWriter(tmp_path / "alone.usdc", tet()), frames(300))
    assert (runs / case / "beside.usdc").read_bytes() == (tmp_path / "alone.usdc").read_bytes()
    assert [path.name for path in (runs / case).iterdir()] == ["beside.usdc"]


@pytest.mark.parametrize(
    ("case", "count"),
    [("not finite", 7), ("last not finite", 7), ("not later", 7), ("closed", 3)],
)
def test_frames_before_a_mistake_are_kept(runs: Path, case: str, count: int) -> None:
    assert len(read_take(runs / case / "beside.usdc")) == count
    assert validate(runs / case / "beside.usdc") == []


@pytest.mark.parametrize(
    ("case", "count"), [("full disk", 3000), ("dropped", 48), ("stopped", 48), ("dies", 48)]
)
def test_frames_without_a_stage_are_recovered(
    runs: Path, tmp_path: Path, case: str, count: int
) -> None:
    """All that the writer was told of, not only those of closed chunks."""
    if case == "dies":
        assert in_a_process(tmp_path, case).code == -signal.SIGKILL
        runs = tmp_path
    path = runs / case / "beside.usdc"
    assert not path.exists()
    assert len(read_take(recover(path))) == count
    assert [entry.name for entry in path.parent.iterdir()] == ["beside.usdc"]


@pytest.mark.parametrize("case", ["nothing", "bad metadata"])
def test_without_a_frame_nothing_is_left(runs: Path, case: str) -> None:
    assert list((runs / case).iterdir()) == []
