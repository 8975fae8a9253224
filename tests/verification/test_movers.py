"""Movers: rigid things of triangle surfaces that push along a path."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import igl
import numpy as np
import pytest
import trimesh

from tests.support.bodies import box, numbers
from tests.verification.pair_bodies import SOFT
from warp_softbody import (
    Character,
    MotionPath,
    Scene,
    Simulation,
    characters,
    mover,
    scene_files,
)
from warp_softbody.errors import InputError, MeshError
from warp_softbody.scenes.stairs import ball_mesh

SPEED = 2.0
ALONG = MotionPath.straight((SPEED, 0.0, 0.0))


def wedge() -> trimesh.Trimesh:
    """A cone whose tip points along +x, at x = -0.01 m."""
    cone = trimesh.creation.cone(0.3, 0.6, sections=24)
    # a quarter of a turn about y takes z to x
    points = cone.vertices[:, [2, 1, 0]] * (1.0, 1.0, -1.0) - (0.61, 0.0, 0.0)
    return trimesh.Trimesh(points, cone.faces, process=False)


def knob() -> trimesh.Trimesh:
    """A ball of facets, whose front is near x = 0."""
    found = trimesh.creation.icosphere(subdivisions=2, radius=0.3)
    return trimesh.Trimesh(found.vertices - (0.3, 0.0, 0.0), found.faces, process=False)


def block() -> trimesh.Trimesh:
    """Of twelve triangles; its front is x = 0."""
    cube = trimesh.creation.box(extents=(0.2, 0.6, 0.6))
    return trimesh.Trimesh(cube.vertices - (0.1, 0.0, 0.0), cube.faces, process=False)


@pytest.mark.parametrize("make", [block, knob, wedge])
def test_a_mover_has_the_surface_given(make: Callable[[], trimesh.Trimesh]) -> None:
    surface = make()
    body, handle = mover(surface, ALONG, name="gate")
    mesh = body.character.mesh
    assert len(mesh.surface) == len(surface.faces) and handle.region == "gate"
    assert mesh.volume == pytest.approx(surface.volume, rel=1e-12)
    found, _, _, _ = igl.signed_distance(
        mesh.points[mesh.surface].reshape(-1, 3),
        np.asarray(surface.vertices, dtype=float),
        np.asarray(surface.faces, dtype=np.int64),
    )[:4]
    assert np.abs(found).max() < 1e-12


@pytest.mark.parametrize(("make", "depth"), [(block, 1e-6), (knob, 2e-3)])
def test_it_pushes_and_is_counted(make: Callable[[], trimesh.Trimesh], depth: float) -> None:
    """A ball is struck at 2 m/s: what the mover gives it gets, and it stays outside.

    Nodes of a ball of facets, 0.05 m wide, are below the flat facets of another by their bulge.
    """
    surface = make()
    body, handle = mover(surface, ALONG, name="gate")
    ball = Character(name="ball", mesh=ball_mesh(0.15, np.array((0.2, 0.0, 0.0))), material=SOFT)
    scene = Scene(character=ball, others=(body,), handles=(handle,), gravity=(0.0, 0.0, 0.0))
    simulation = Simulation(scene, time_step=0.01, fps=100.0)
    nodes = simulation.model.scene.parts[0].nodes
    masses, given = simulation.model.masses[nodes], np.zeros(3)
    faces = np.asarray(surface.faces, dtype=np.int64)
    for _ in range(40):
        simulation.step()
        given += 0.01 * simulation.frame().contacts.force_on("ball", by="gate")
        ahead = numbers(simulation.state.positions)[nodes] - (SPEED * simulation.time, 0.0, 0.0)
        away = igl.signed_distance(ahead, np.asarray(surface.vertices, dtype=float), faces)[0]
        assert away.min() > -depth
    momentum = masses @ numbers(simulation.state.velocities)[nodes]
    np.testing.assert_allclose(momentum, given, atol=1e-3 * np.abs(given).max())
    assert momentum[0] / masses.sum() > SPEED


@pytest.mark.parametrize("speed", [5.0, 20.0, 50.0])
@pytest.mark.parametrize("make_letter", [characters.letter_i, characters.letter_t])
def test_fast_and_finely_meshed(make_letter: Callable[[], Character], speed: float) -> None:
    """A round mover of 320 triangles, up to 0.8 m a step: momentum given is momentum taken.

    Its nodes meet the same few triangles of a letter, whose rows nearly repeat each other. No node
    goes through it: at the end none is inside, and none was as deep as half an edge of 0.1 m.
    """
    letter = make_letter()
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.15)
    low, points = letter.mesh.points.min(axis=0), letter.mesh.points
    start = np.array((low[0] - 0.2, points[:, 1].mean(), 0.5))
    surface = trimesh.Trimesh(ball.vertices + start, ball.faces, process=False)
    body, handle = mover(surface, MotionPath.straight((speed, 0.0, 0.0)))
    scene = Scene(character=letter, others=(body,), handles=(handle,), gravity=(0.0, 0.0, 0.0))
    simulation = Simulation(scene, time_step=1.0 / 60.0, fps=60.0)
    nodes = simulation.model.scene.parts[0].nodes
    masses, given, deepest = simulation.model.masses[nodes], np.zeros(3), 0.0
    for _ in range(round(60.0 * (0.15 + 0.5 / speed))):
        simulation.step()
        given += simulation.frame().contacts.force_on(letter.name, by="mover") / 60.0
        ahead = numbers(simulation.state.positions)[nodes] - (speed * simulation.time, 0.0, 0.0)
        faces = np.asarray(surface.faces, dtype=np.int64)
        away = igl.signed_distance(ahead, np.asarray(surface.vertices, dtype=float), faces)[0]
        deepest = max(deepest, -float(away.min()))
    momentum = masses @ numbers(simulation.state.velocities)[nodes]
    np.testing.assert_allclose(momentum, given, atol=1e-3 * np.abs(given).max())
    assert momentum[0] / masses.sum() > speed
    assert away.min() > 0.0
    assert deepest < 0.05


def test_scene_files_have_movers(tmp_path: Path) -> None:
    block().export(tmp_path / "gate.obj")
    text = (
        '[character]\nshape = "ball"\nradius = 0.1\n'
        '[[movers]]\nname = "gate"\nfile = "gate.obj"\ntranslation = [-1.0, 0.0, 0.3]\n'
        "path = { velocity = [1.0, 0.0, 0.0] }\n"
        '[[movers]]\nname = "wall"\nshape = "box"\nsize = [0.1, 1.0, 1.0]\n'
        "path = { rate = 90.0 }\n"
    )
    (tmp_path / "own.toml").write_text(text)
    plan = scene_files.read(tmp_path / "own.toml").plan
    assert [body.name for body in plan.scene.characters] == ["ball", "gate", "wall"]
    assert [handle.region for handle in plan.scene.handles] == ["gate", "wall"]
    scene_files.write(tmp_path / "again.toml", plan)
    assert scene_files.read(tmp_path / "again.toml").plan.scene == plan.scene
    (tmp_path / "wrong.toml").write_text(text.replace("gate.obj", "none.obj"))
    with pytest.raises(InputError, match=r"6: movers.0..file: .*there is no such file"):
        scene_files.read(tmp_path / "wrong.toml")


def test_what_moves_nothing_is_refused() -> None:
    open_box = block()
    open_box.faces = open_box.faces[:-1]
    with pytest.raises(MeshError, match="not closed"):
        mover(open_box, ALONG)
    with pytest.raises(InputError, match="path of mover must be a MotionPath"):
        mover(box(), (1.0, 0.0, 0.0))  # type: ignore[arg-type]
