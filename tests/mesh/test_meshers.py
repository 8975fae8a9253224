"""Both meshers keep the body; a child process that fails becomes one sentence."""

from __future__ import annotations

import importlib.util
import os
import signal
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh

from warp_softbody.errors import InputError, MeshError, MissingExtraError
from warp_softbody.mesh import TetMesh
from warp_softbody.meshing import child, load_surface
from warp_softbody.meshing.check import check_against_surface

needs_tetgen = pytest.mark.skipif(
    importlib.util.find_spec("tetgen") is None, reason="TetGen is an optional extra"
)

both_meshers = pytest.mark.parametrize(
    ("mesher", "tolerance"), [pytest.param("tetgen", 1e-9, marks=needs_tetgen), ("ftetwild", 3e-3)]
)


@both_meshers
def test_box_keeps_volume_box_and_parts(
    box: trimesh.Trimesh, mesher: str, tolerance: float, capfd: pytest.CaptureFixture[str]
) -> None:
    mesh = TetMesh.from_surface(box, mesher=mesher, size=0.25)
    assert mesh.volume == pytest.approx(0.15, rel=tolerance)
    np.testing.assert_allclose(mesh.bounds, box.bounds, atol=tolerance)
    assert mesh.part_count == 1
    assert (mesh.volumes > 0.0).all()
    assert capfd.readouterr() == ("", "")


@both_meshers
def test_size_is_about_the_mean_edge(box: trimesh.Trimesh, mesher: str, tolerance: float) -> None:
    for size in (0.25, 0.1):
        mesh = TetMesh.from_surface(box, mesher=mesher, size=size)
        assert 0.65 < mean_edge(mesh) / size < 1.5


def mean_edge(mesh: TetMesh) -> float:
    """Mean length over the six edges of all tets, m."""
    corners = mesh.points[mesh.tets]
    edges = corners[:, [0, 0, 0, 1, 1, 2]] - corners[:, [1, 2, 3, 2, 3, 3]]
    return float(np.linalg.norm(edges, axis=2).mean())


@needs_tetgen
def test_tetgen_is_repeatable(box: trimesh.Trimesh) -> None:
    first, second = (TetMesh.from_surface(box, mesher="tetgen", size=0.1) for _ in range(2))
    np.testing.assert_array_equal(first.points, second.points)
    np.testing.assert_array_equal(first.tets, second.tets)


@needs_tetgen
def test_self_intersection_is_one_sentence(box: trimesh.Trimesh) -> None:
    box.vertices[0] = (2.0, 2.0, 2.0)
    with pytest.raises(MeshError, match=r"tetgen could not mesh the surface: .*self-intersections"):
        TetMesh.from_surface(box, mesher="tetgen")


def test_missing_tetgen_names_the_extra(
    box: trimesh.Trimesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match=r'pip install "warp-softbody\[tetgen\]"'):
        TetMesh.from_surface(box, mesher="tetgen")


@pytest.mark.parametrize("size", [0.0, -1.0, float("nan"), float("inf")])
def test_size_must_be_positive(box: trimesh.Trimesh, size: float) -> None:
    with pytest.raises(InputError, match="mesh size must be a positive number of m"):
        TetMesh.from_surface(box, size=size)


def test_unknown_mesher(box: trimesh.Trimesh) -> None:
    with pytest.raises(InputError, match="no mesher 'magic'; there are: ftetwild, tetgen"):
        TetMesh.from_surface(box, mesher="magic")


def run_worker(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, body: str, timeout: float = 30.0
) -> None:
    """Run a made-up worker in place of the real one."""
    worker = tmp_path / "worker.py"
    worker.write_text(body)
    monkeypatch.setattr(child, "WORKER", worker)
    child.run_mesher(
        "tetgen", np.zeros((1, 3)), np.zeros((1, 3), np.int32), {}, source="it", timeout=timeout
    )


@pytest.mark.parametrize(
    ("body", "sentence"),
    [
        ("import os; os.kill(os.getpid(), 11)", "it was ended by SIGSEGV"),
        ("import sys; sys.exit(7)", "it ended with status 7"),
        ("", "it left no result"),
    ],
)
def test_crash_is_one_sentence(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, body: str, sentence: str
) -> None:
    with pytest.raises(MeshError, match=f"^it: tetgen could not mesh the surface: {sentence}$"):
        run_worker(monkeypatch, tmp_path, body)


def test_timeout_is_one_sentence(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"^it: tetgen did not finish in 0.3 s"):
        run_worker(monkeypatch, tmp_path, "import time; time.sleep(60)", timeout=0.3)


def test_interrupt_ends_the_child(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    note = tmp_path / "pid"
    body = (
        "import os, pathlib, signal, time\n"
        "signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        f"pathlib.Path({str(note)!r}).write_text(str(os.getpid()))\n"
        "time.sleep(60)\n"
    )

    def interrupt() -> None:
        while not (note.exists() and note.read_text()):
            time.sleep(0.02)
        os.kill(os.getpid(), signal.SIGINT)

    # a shell that runs this in the background leaves interrupts ignored
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Thread(target=interrupt, daemon=True).start()
    try:
        with pytest.raises(KeyboardInterrupt):
            run_worker(monkeypatch, tmp_path, body)
    finally:
        signal.signal(signal.SIGINT, before)
    with pytest.raises(ProcessLookupError):
        os.kill(int(note.read_text()), 0)


def test_check_refuses_another_box(cube: TetMesh) -> None:
    half = trimesh.creation.box(bounds=[[0.0, 0.0, 0.0], [1.0, 1.0, 0.5]])
    with pytest.raises(MeshError, match=r"box of the mesh by it lies 0\.5 m from the surface's"):
        check_against_surface(cube, load_surface(half), mesher="it", envelope=1e-3)


def test_check_refuses_another_volume(cube: TetMesh) -> None:
    ball = trimesh.creation.icosphere(3, radius=0.5)
    ball.apply_translation((0.5, 0.5, 0.5))
    with pytest.raises(MeshError, match=r"a volume of 1 m\^3, but the surface encloses 0\.5"):
        check_against_surface(cube, load_surface(ball), mesher="it", envelope=1e-2)


def test_check_refuses_two_parts(cube: TetMesh) -> None:
    points = np.concatenate([cube.points, cube.points + 5.0])
    tets = np.concatenate([cube.tets, cube.tets + 8])
    pair = TetMesh.from_arrays(points, tets, allow_parts=True)
    whole = load_surface(trimesh.creation.box((1.0, 1.0, 1.0)))
    with pytest.raises(MeshError, match="it made 2 separate parts of one surface"):
        check_against_surface(pair, whole, mesher="it", envelope=1e-3)
