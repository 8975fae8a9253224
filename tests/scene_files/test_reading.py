"""What a scene file may say, and how it is told of what it may not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.support.bodies import box, muscular_bar
from warp_softbody import (
    Handle,
    HeightField,
    Material,
    MotionPath,
    Plane,
    TriangleGround,
    characters,
    scene_files,
)
from warp_softbody.body.character import Character
from warp_softbody.controllers import Walk
from warp_softbody.controllers.arguments import arguments_of, suited_by
from warp_softbody.errors import InputError
from warp_softbody.run.simulation import Simulation
from warp_softbody.scene_files.first_scene import TEXT
from warp_softbody.scene_files.scene_file import SceneFile
from warp_softbody.scenes.plan import ScenePlan
from warp_softbody.world.scene import Scene

SMALL = """\
[character]
name = "cube"
shape = "box"
size = [0.2, 0.2, 0.2]
cells = [2, 2, 2]
"""


HANDLE = SMALL + "[[handles]]\nregion = 'cube'\n"
MOVER = "[[movers]]\nshape = 'ball'\nradius = 0.1\npath = { rate = 3 }\n"


def written(folder: Path, text: str) -> SceneFile:
    (folder / "own.toml").write_text(text, encoding="utf-8")
    return scene_files.read(folder / "own.toml")


def test_the_first_scene_moves(tmp_path: Path) -> None:
    file = written(tmp_path, TEXT.format(name="first"))
    scene = file.plan.scene
    assert [body.name for body in scene.characters] == ["letter_i", "ball", "paddle"]
    assert scene.others[0].spin == (0.0, 6.0, 0.0)
    simulation = file.simulation()
    for _ in range(5):
        simulation.step()
    moved = simulation.state.velocities.numpy()[scene.handle_nodes[0]]
    assert (moved[:, 0] < 0.0).all()


def test_regions_fixed_nodes_and_places(tmp_path: Path) -> None:
    text = SMALL + (
        'fixed = "bottom"\n'
        "translation = [1.0, 0.0, 0.0]\n"
        "degrees = 90.0\n"
        "velocity = [0.0, 0.0, 1.0]\n"
        "[character.regions]\n"
        "bottom = { high = [1.0, 1.0, 1e-9] }\n"
        "some = [3, 1]\n"
        "[character.material]\n"
        "density = 500\n"
    )
    character = written(tmp_path, text).plan.scene.character
    bottom = np.flatnonzero(character.mesh.points[:, 2] < 1e-9)
    np.testing.assert_array_equal(character.fixed, bottom)
    np.testing.assert_array_equal(character.region("some"), [1, 3])
    assert character.material == Material(density=500.0)
    assert character.mesh.points[:, 0].mean() == pytest.approx(1.0)


def test_a_material_with_a_name_is_the_whole_one(tmp_path: Path) -> None:
    text = '[materials.hard]\nyoung_modulus = 1e7\n[character]\nshape = "letter_i"\n'
    character = written(tmp_path, text + 'material = "hard"\n').plan.scene.character
    assert character.material == Material(young_modulus=1e7)


def test_characters_meshes_and_muscles(tmp_path: Path) -> None:
    bar = muscular_bar()
    bar.save(tmp_path / "bar.char")
    assert written(tmp_path, '[character]\nfile = "bar.char"\n').plan.scene.character == bar
    box((1, 1, 1)).write(tmp_path / "mesh.vtu")
    text = (
        '[character]\nfile = "mesh.vtu"\nname = "own"\n'
        '[[character.muscles]]\nname = "m"\nstrength = 1e5\nkernel_width = 0.1\n'
        'fibers = [{ name = "f", vertices = [[0.1, 0.1, 0.05], [0.1, 0.1, 0.15]] }]\n'
    )
    own = written(tmp_path, text).plan.scene.character
    assert (own.name, own.segment_count) == ("own", 1)


def test_grounds(tmp_path: Path) -> None:
    flat = '[ground]\nkind = "plane"\nnormal = [0.0, 1.0, 1.0]\noffset = -0.5\n'
    assert written(tmp_path, flat + SMALL).plan.scene.ground == Plane(
        normal=(0.0, 1.0, 1.0), offset=-0.5
    )
    heights = np.array([[0.0, 0.1], [0.2, 0.3]])
    expected = HeightField(heights=heights, spacing=(1.0, 2.0))
    for source in ("heights = [[0, 0.1], [0.2, 0.3]]", 'file = "h.npy"', 'file = "h.csv"'):
        np.save(tmp_path / "h.npy", heights)
        np.savetxt(tmp_path / "h.csv", heights, delimiter=",")
        text = f'[ground]\nkind = "heights"\nspacing = [1.0, 2.0]\n{source}\n'
        assert written(tmp_path, text + SMALL).plan.scene.ground == expected
    (tmp_path / "g.obj").write_text("v 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n")
    text = '[ground]\nkind = "triangles"\nfile = "g.obj"\n'
    expected_mesh = TriangleGround(vertices=np.eye(3), faces=np.array([[0, 1, 2]], dtype=np.int32))
    assert written(tmp_path, text + SMALL).plan.scene.ground == expected_mesh


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("0,nan\n1,2\n", "3: ground.file: file .*h.csv: HeightField.heights must be .* holds nan"),
        ("0,1\n", "3: ground.file: file .*h.csv: HeightField.heights must be a grid"),
        ("", "3: ground.file: file .*h.csv: HeightField.heights must be a grid"),
    ],
)
def test_a_file_of_heights_is_named(content: str, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "h.csv").write_text(content)
    with pytest.raises(InputError, match=sentence):
        written(tmp_path, '[ground]\nkind = "heights"\nfile = "h.csv"\n' + SMALL)


def test_handles_let_go_in_files(tmp_path: Path) -> None:
    text = HANDLE + "path = { velocity = [1, 0, 0] }\nuntil = 0.25\n"
    plan = written(tmp_path, text).plan
    assert plan.scene.handles[0].until == 0.25
    scene_files.write(tmp_path / "again.toml", plan)
    assert scene_files.read(tmp_path / "again.toml").plan.scene == plan.scene
    line = text.count("\n")
    with pytest.raises(InputError, match=f":{line}: handles.0..until: Handle.until must be"):
        written(tmp_path, text.replace("0.25", "-1"))


def test_handles_take_short_paths(tmp_path: Path) -> None:
    text = (
        SMALL + "[[handles]]\nregion = 'cube'\npath = { velocity = [1, 0, 0] }\n"
        "[[bodies]]\nname = 'b'\nshape = 'ball'\nradius = 0.1\ncenter = [1, 0, 0.1]\n"
        "[[handles]]\nregion = 'b'\npath = { rate = 90, axis = [1, 0, 0] }\n"
    )
    one, other = written(tmp_path, text).plan.scene.handles
    assert one.path == MotionPath.straight((1.0, 0.0, 0.0))
    assert other.path == MotionPath.spinning(90.0, (1.0, 0.0, 0.0))


def test_each_body_may_have_a_controller(tmp_path: Path) -> None:
    letter = 'shape = "letter_i"\ncoarse = 1\n'
    text = f'[character]\n{letter}[controller]\nkind = "balance"\n[[bodies]]\n{letter}'
    text += 'name = "second"\ntranslation = [1.0, 0.0, 0.0]\n'
    file = written(tmp_path, text + '[bodies.controller]\nkind = "balance"\nbase = "head"\n')
    (other,) = file.plan.others.values()
    known = arguments_of(other)
    assert known is not None and known["base"] == "head"
    scene_files.write(tmp_path / "again.toml", file)
    again = scene_files.read(tmp_path / "again.toml").plan
    assert again.scene == file.plan.scene
    assert arguments_of(again.others["second"]) == known
    with pytest.raises(InputError, match="there is no key 'controller'"):
        written(tmp_path, f"[character]\n{letter}controller = 1\n")


def test_controllers_made_for_a_body_come_back(tmp_path: Path) -> None:
    """With the arguments that they were made with, and the same first steps."""
    letter = characters.letter_x(coarse=1)
    walks = [Walk.for_(letter, heading=0.5) for _ in range(2)]
    plan = ScenePlan(
        name="own",
        description="a walk",
        scene=Scene(character=letter, ground=Plane()),
        controller=walks[0],
        seconds=1.0,
        time_step=1.0 / 60.0,
        settings={},
    )
    scene_files.write(tmp_path / "own.toml", plan)
    file = scene_files.read(tmp_path / "own.toml")
    assert suited_by(file.plan.controller) == suited_by(walks[0])
    text = (tmp_path / "own.toml").read_text()
    assert 'kind = "walk"\nfor_body = true\nheading = 0.5\n' in text
    ends = []
    for simulation in (
        Simulation(plan.scene, walks[1], time_step=plan.time_step),
        file.simulation(),
    ):
        *_, last = simulation.run(0.1)
        ends.append(last.positions)
    np.testing.assert_array_equal(ends[0], ends[1])


def test_directions_come_back_to_the_last_bit(tmp_path: Path) -> None:
    """A unit vector that is read is not divided by its length again."""
    for number, normal in enumerate(np.random.default_rng(1).normal(size=(20, 3))):
        scene = Scene(
            character=Character(name="cube", mesh=box((1, 1, 1))),
            ground=Plane(normal=tuple(normal)),
            handles=(Handle(region="cube", path=MotionPath.spinning(30.0, tuple(normal))),),
        )
        plan = ScenePlan(
            name="own",
            description="turning",
            scene=scene,
            controller=None,
            seconds=1.0,
            time_step=0.01,
            settings={},
        )
        scene_files.write(tmp_path / f"{number}.toml", plan)
        assert scene_files.read(tmp_path / f"{number}.toml").plan.scene == scene


def test_options_and_output(tmp_path: Path) -> None:
    text = (
        SMALL + "[options]\ntime_step = 0.005\ncone = '8'\n[output]\nfps = 100\nstage = 'a.usdc'\n"
    )
    file = written(tmp_path, text)
    assert file.options == {"time_step": 0.005, "cone": "8"}
    assert file.output.fps == 100.0 and file.output.stage == "a.usdc"
    assert file.simulation().model.options.cone == "8"


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("young_modulus = 2e5", "yung_modulus = 2e5", "37: materials.rubber.yung_modulus: .*did "
         "you mean 'young_modulus'"),
        ("[ground]", "[grond]", "6: grond: there is no key 'grond'; did you mean 'ground'"),
        ("friction = 0.8", "friction = -1", "8: ground.friction: Plane.friction must be"),
        ("[300.0,", '["a",', "31: pushes.0..force: Push.force must be 3 finite numbers of N"),
        ('"head"', '"hed"', "30: pushes.0..region: .*no region 'hed'; it has: base"),
        ('"balance"', '"ballance"', "26: controller.kind: .*did you mean 'balance'"),
        ('"ease"', '"eaze"', "66: handles.0..path.between: MotionPath.between must be one of"),
        ('region = "paddle"', 'region = "padle"', "61: handles.0..region: no region or body"),
        ('material = "rubber"', 'material = "ruber"', "48: bodies.0..material: there is no"),
        ("[1, 4, 4]", "[1, 4, 0]", "57: bodies.1..cells: cells must be a whole number"),
        ("time_step = 0.01", "time_step = -0.01", "70: options.time_step: SimulationOptions.time"),
        ("radius = 0.1", "radius = nan", "46: bodies.0..radius: radius must be a positive number"),
        ("seconds = 4.0", "seconds = true", "4: seconds: seconds must be a positive number"),
        ('shape = "letter_i"', 'shape = "letter_j"', "13: character.shape: .*mean 'letter_"),
        ('shape = "letter_i"', 'file = "../no.char"', "13: character.file: .*no such file"),
        ('shape = "letter_i"', "", "12: character: the key 'shape' is missing"),
        ("longitudinal = 1.2e6", "radial = 1.2e6", "23: character.strengths.radial: there is no"),
        ("seconds = 4.0", "seconds = ", "it is no TOML: .*line 4"),
        ('name = "ball"', 'name = "letter_i"', "two bodies of the scene have the name 'letter_i'"),
        ("start = 0.5", "", "29: pushes.0.: the key 'start' is missing"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told_with_its_line(
    old: str, new: str, sentence: str, tmp_path: Path
) -> None:
    text = TEXT.format(name="first")
    assert old in text
    with pytest.raises(InputError, match=sentence) as raised:
        written(tmp_path, text.replace(old, new, 1))
    assert str(raised.value).startswith(f"{tmp_path / 'own.toml'}:")
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", r"1: the table \[character\] is missing"),
        ("character = 3\n", "1: character: must be a table, not 3"),
        (SMALL + "[world]\ngravity = [0, 0]\n", "7: world.gravity: Scene.gravity must be 3 finite"),
        (SMALL + "[world]\nself_contact = 1\n", "7: world.self_contact: Scene.self_contact must"),
        (SMALL + "[[ground]]\n", "6: ground: must be a table"),
        (SMALL + "[output]\nstage = '/etc/x.usdc'\n", "7: output.stage: .*leads out of it"),
        (SMALL + "[output]\nmovie = '../x.gif'\n", "7: output.movie: .*leads out of it"),
        (SMALL + "bodies = 1\n", "6: character.bodies: there is no key"),
        ("bodies = [1]\n" + SMALL, "1: bodies: must be an array of tables"),
        (SMALL + "fixed = 'top'\n", "6: character.fixed: character 'cube' has no region 'top'"),
        (SMALL + "fixed = {low=[9,9,9]}\n", "6: character.fixed: no node of the body"),
        (SMALL + "cells = 3\n", "no TOML: "),
        (SMALL + "fixed = {low=[0.02]}\n", "6: character.fixed.low: low must be an array of num"),
        (SMALL + "fixed = {high='a'}\n", "6: character.fixed.high: high must be an array of num"),
        (SMALL + "file = 'a.char'\n", "6: character.file: goes without 'shape': a body has one"),
        ("[character]\n", "1: character: the key 'shape' is missing, or 'file' in its place"),
        (SMALL + "[[movers]]\nfile='a.stl'\nshape='box'\n", r"7: movers\[0\].file: goes without"),
        (HANDLE + "path = { velocity = [1, 0, 0], rate = 3 }\n", "8: .*path.rate: goes without 'v"),
        (HANDLE + "path = {}\n", "8: .*path: a path needs 'velocity', 'rate' or 'times'"),
        (SMALL + "[controller]\nkind = 'walk'\n", "6: controller: the key 'gait' .*`for_body = t"),
        (SMALL + "[character]\n", "own.toml:6: it is no TOML: .*: '\\[character\\]'"),
        (SMALL + "shape = 'ball'\n", "own.toml:6: it is no TOML: .*shape = 'ball'"),
        (SMALL + MOVER + MOVER, r"10: movers\[1\]: two bodies .* 'mover'; give it another 'name'"),
        (SMALL + "strengths = {a = 1}\n", "6: character.strengths: the body has no muscles"),
        (SMALL + "materials = {top = {density = 1}}\n", "6: character.materials.top: the body has"),
        (
            SMALL + "regions = {top = [0, 1]}\nmaterials = {top = {density = 1}}\n",
            "7: character.materials.top: region 'top' holds no whole tet",
        ),
        (
            SMALL + "[[character.directional_friction]]\nregion = 'top'\ndirection = [1, 0, 0]\n",
            r"7: character.directional_friction\[0\].region: the body has no region 'top'",
        ),
        (SMALL + "fixed = {}\n", "6: character.fixed: a box needs 'low' or 'high'"),
        (SMALL + "regions = {top=[]}\n", "6: character.regions.top: holds no nodes"),
        (SMALL + "regions = {top=[99]}\n", "6: character.regions.top: .* but it holds 99"),
    ],
)
def test_shapes_of_tables_are_told(text: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=sentence):
        written(tmp_path, text)


def test_files_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no such file"):
        scene_files.read(tmp_path / "none.toml")
    with pytest.raises(InputError, match=r"must end in \.toml"):
        scene_files.read(tmp_path / "none.json")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="no text in UTF-8"):
        scene_files.read(tmp_path / "bytes.toml")


def test_a_body_beside_another_of_its_own_file(tmp_path: Path) -> None:
    """Characters of one name in one scene are refused before anything is written over another."""
    one = Character(name="a", mesh=box())
    with pytest.raises(InputError, match="name 'a'"):
        one.save(tmp_path / "a.char")
        text = '[character]\nfile = "a.char"\n[[bodies]]\nfile = "a.char"\n'
        written(tmp_path, text)
