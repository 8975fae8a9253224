"""Both meshers keep the body; a child process that fails becomes one sentence."""

from __future__ import annotations

import importlib.util
import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from tests.support.processes import start_python
from warp_softbody.body.character import Character
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.meshing import load_surface
from warp_softbody.body.meshing.check import check_against_surface
from warp_softbody.body.meshing.child import run_mesher
from warp_softbody.body.meshing.ftetwild_mesher import mesh_with_ftetwild
from warp_softbody.body.muscles import Fiber, FiberKind, MuscleGroup
from warp_softbody.engine.muscle_layout import build_muscle_layout
from warp_softbody.errors import InputError, MeshError, MeshWarning, MissingExtraError, OutputError

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
    sentence = "triangles cross each other, .* which tetgen does not take"
    with pytest.warns(MeshWarning), pytest.raises(MeshError, match=sentence):
        TetMesh.from_surface(box, mesher="tetgen")


def test_missing_tetgen_names_the_extra(
    box: trimesh.Trimesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match=r'pip install "warp-softbody\[tetgen\]"'):
        TetMesh.from_surface(box, mesher="tetgen")


@pytest.mark.parametrize("size", [0.0, -1.0, float("nan"), float("inf"), "0.1", True])
def test_size_must_be_positive(box: trimesh.Trimesh, size: Any) -> None:
    with pytest.raises(InputError, match="mesh size must be a positive number of m"):
        TetMesh.from_surface(box, size=size)


def test_a_size_that_asks_for_too_much(box: trimesh.Trimesh) -> None:
    for size in (1e-4, 1e-300):
        with pytest.raises(InputError, match=r"surface: a mesh size of .* m asks for some .* tets"):
            TetMesh.from_surface(box, size=size)


@needs_tetgen
def test_a_size_beyond_the_body_is_that_of_the_body(box: trimesh.Trimesh) -> None:
    assert TetMesh.from_surface(box, mesher="tetgen", size=1e29).volume == pytest.approx(0.15)


def test_unknown_mesher(box: trimesh.Trimesh) -> None:
    with pytest.raises(InputError, match="no mesher 'magic'; there are: ftetwild, tetgen"):
        TetMesh.from_surface(box, mesher="magic")


def run_worker(tmp_path: Path, body: str, timeout: float = 30.0) -> None:
    """Run a made-up worker in place of the real one."""
    worker = tmp_path / "worker.py"
    worker.write_text(body)
    points, faces = np.zeros((1, 3)), np.zeros((1, 3), np.int32)
    limits: dict[str, Any] = {"timeout": timeout, "grace": 0.1}
    run_mesher("tetgen", points, faces, {}, source="it", worker=worker, **limits)


@pytest.mark.parametrize(
    ("body", "sentence"),
    [
        ("import os; os.kill(os.getpid(), 11)", "it was ended by SIGSEGV"),
        ("import sys; sys.exit(7)", "it ended with status 7"),
        ("", "it left no result"),
    ],
)
def test_crash_is_one_sentence(tmp_path: Path, body: str, sentence: str) -> None:
    with pytest.raises(MeshError, match=f"^it: tetgen could not mesh the surface: {sentence}$"):
        run_worker(tmp_path, body)


def test_timeout_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"^it: tetgen did not finish in 0.3 s"):
        run_worker(tmp_path, "import time; time.sleep(60)", timeout=0.3)


def test_interrupt_ends_the_child(tmp_path: Path) -> None:
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
            run_worker(tmp_path, body)
    finally:
        signal.signal(signal.SIGINT, before)
    with pytest.raises(ProcessLookupError):
        os.kill(int(note.read_text()), 0)


def compare(points: Any, tets: Any, surface: trimesh.Trimesh, *, envelope: float) -> None:
    check_against_surface(points, tets, load_surface(surface), mesher="it", envelope=envelope)


def test_check_refuses_another_box(cube: TetMesh) -> None:
    half = trimesh.creation.box(bounds=[[0.0, 0.0, 0.0], [1.0, 1.0, 0.5]])
    with pytest.raises(MeshError, match=r"box of the mesh by it lies 0\.5 m from the surface's"):
        compare(cube.points, cube.tets, half, envelope=1e-3)


def test_check_refuses_another_volume(cube: TetMesh) -> None:
    ball = trimesh.creation.icosphere(3, radius=0.5)
    ball.apply_translation((0.5, 0.5, 0.5))
    with pytest.raises(MeshError, match=r"a volume of 1 m\^3, but the surface encloses 0\.5"):
        compare(cube.points, cube.tets, ball, envelope=1e-2)


def test_check_refuses_two_parts(cube: TetMesh) -> None:
    points = np.concatenate([cube.points, cube.points + 5.0])
    tets = np.concatenate([cube.tets, cube.tets + 8])
    whole = trimesh.creation.box((1.0, 1.0, 1.0))
    with pytest.raises(MeshError, match="it made 2 separate parts of one surface"):
        compare(points, tets, whole, envelope=1e-3)


def test_no_temporary_folder_is_one_sentence(
    box: trimesh.Trimesh, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    sentence = "it: there is no temporary folder for tetgen; TMPDIR names another one"
    with pytest.raises(OutputError, match=sentence):
        run_worker(tmp_path, "import sys; sys.exit(73)")
    monkeypatch.setattr(sys, "executable", str(tmp_path / "absent"))
    with pytest.raises(OutputError, match="surface: ftetwild cannot be started: No such file"):
        TetMesh.from_surface(box)


def test_micrometres_are_metres_scaled(box: trimesh.Trimesh) -> None:
    small = trimesh.Trimesh(1e-6 * box.vertices, box.faces, process=False)
    mesh = TetMesh.from_surface(small, size=4e-7)
    assert mesh.volume == pytest.approx(0.15e-18, rel=3e-3)
    np.testing.assert_allclose(mesh.bounds, 1e-6 * box.bounds, atol=3e-9)


def test_a_body_thinner_than_the_envelope_is_refused() -> None:
    plate = trimesh.creation.box((1.0, 1.0, 1e-3))
    sentence = r"only some 0\.000998 m thick, but ftetwild may move each side by 0\.00141 m; use"
    with pytest.raises(MeshError, match=sentence):
        TetMesh.from_surface(plate)


def test_plate_that_takes_too_long_tells_the_remedy() -> None:
    plate = load_surface(trimesh.creation.box((1.0, 1.0, 3e-3)))
    sentence = r"ftetwild did not finish in .* the body is only some 0\.00298 m thick, .*'tetgen'"
    with pytest.raises(MeshError, match=sentence):
        mesh_with_ftetwild(plate, 0.1 * plate.diagonal, timeout=0.5)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGKILL])
def test_whoever_ends_the_caller_ends_the_mesher(tmp_path: Path, number: signal.Signals) -> None:
    surface = tmp_path / "plate.stl"
    trimesh.creation.box((1.0, 1.0, 3e-3)).export(surface)
    spare = tmp_path / "spare"
    spare.mkdir()
    command = ("-m", "warp_softbody", "mesh", surface, "-o", tmp_path / "plate.vtu")
    caller = start_python(*command, environment={"TMPDIR": str(spare)})
    wait_until(lambda: bool(list(spare.iterdir())))
    caller.send_signal(number)
    killed = number == signal.SIGKILL
    assert caller.wait() == (-number if killed else 128 + number)
    wait_until(lambda: not list(spare.iterdir()))
    assert [entry.name for entry in sorted(tmp_path.iterdir())] == ["plate.stl", "spare"]


def wait_until(done: Callable[[], bool]) -> None:
    """Fail where something does not happen within half a minute."""
    deadline = time.monotonic() + 30.0
    while not done():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_fibres_at_the_skin_of_a_meshed_starfish(tmp_path: Path) -> None:
    mesh, tips, thick = starfish(tmp_path / "starfish.obj")
    for depth in (2e-3, 5e-4, 1e-4, 0.0):
        lines = [np.outer(np.linspace(0.1, 0.9, 7), (*tip, 0.0)) for tip in tips]
        fibers = tuple(
            Fiber(
                name=f"arm_{arm}",
                kind=FiberKind.LONGITUDINAL,
                vertices=line + np.array([0.0, 0.0, thick - depth]),
            )
            for arm, line in enumerate(lines)
        )
        group = MuscleGroup(name="top", fibers=fibers, strength=3e5, kernel_width=0.04)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MeshWarning)
            layout = build_muscle_layout(Character(name="star", mesh=mesh, muscles=(group,)))
        np.testing.assert_allclose(layout.rest_lengths, 0.3 * 0.8 / 6, rtol=0.05)


def starfish(path: Path) -> tuple[TetMesh, NDArray[np.float64], float]:
    """A star of five arms filled from its OBJ, the tips (5, 2) of its arms and its thickness, m."""
    thick, count = 0.06, 10
    angle = np.pi / 2 + np.pi * np.arange(count) / 5
    radius = np.where(np.arange(count) % 2 == 0, 0.3, 0.1)
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    points = [(*p, z) for z in (0.0, thick) for p in ring] + [(0.0, 0.0, 0.0), (0.0, 0.0, thick)]
    faces = []
    for i in range(count):
        j = (i + 1) % count
        faces += [(count + i, count + j, 2 * count + 1), (j, i, 2 * count)]
        faces += [(i, j, count + j), (i, count + j, count + i)]
    lines = ["v {:.9f} {:.9f} {:.9f}".format(*point) for point in points]
    lines += ["f {} {} {}".format(*(corner + 1 for corner in face)) for face in faces]
    path.write_text("\n".join(lines))
    return TetMesh.from_surface(path), ring[::2], thick
