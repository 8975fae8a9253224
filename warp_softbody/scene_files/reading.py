"""A scene file is read, and every value of it checked where it stands."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from warp_softbody.body.material import Material
from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.controllers.controller import Controller
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.scene_files.bodies import CONTROLLER, body_of
from warp_softbody.scene_files.grounds import ground_of
from warp_softbody.scene_files.motions import controller_of
from warp_softbody.scene_files.movers import mover_of
from warp_softbody.scene_files.moving import fields_of, handles_of, pushes_of
from warp_softbody.scene_files.records import record_of
from warp_softbody.scene_files.runnable import refuse_other_folders, refuse_what_cannot_run
from warp_softbody.scene_files.scene_file import RunOutput, SceneFile
from warp_softbody.scene_files.tables import Table, read_tables
from warp_softbody.scenes.plan import ScenePlan
from warp_softbody.world.handles import Handle, acted_on, nodes_of_handles, pushed_nodes
from warp_softbody.world.scene import Scene

EXTENSION = ".toml"
TEXTS = ("name", "description")
TABLES = ("world", "ground", "materials", "character", "controller", "options", "control", "output")
ARRAYS = ("bodies", "movers", "pushes", "handles", "fields")
KEYS = (*TEXTS, "seconds", *TABLES, *ARRAYS)
WORLD = ("gravity", "body_friction", "self_contact")
SECONDS, TIME_STEP = 3.0, 1.0 / 120.0


def read_scene_file(path: str | Path) -> SceneFile:
    """The scene of a TOML file (docs/scene-files.md); nothing that a file holds is run.

    Raises:
        InputError: the file is missing, is no TOML, has a key that there is not, or a value that
            cannot be; with file, line and field.
    """
    file = input_kinds.path("path of a scene file", path)
    if file.suffix.lower() != EXTENSION:
        raise InputError(f"{file}: a scene file must end in {EXTENSION}")
    table = read_tables(file)
    table.only(KEYS)
    options = _options(table.table("options"), SimulationOptions)
    with table.explained():
        plan = ScenePlan(
            name=table.text("name", file.stem),
            description=table.text("description", "a scene of its own"),
            scene=(scene := _scene(table)),
            controller=controller_of(table.table("controller"), scene.character)
            if "controller" in table
            else None,
            seconds=checks.number("seconds", table.take("seconds", SECONDS), above=0.0, unit="s"),
            time_step=options.get("time_step", TIME_STEP),
            settings={},
            others=_others(table, scene),
        )
    control = _options(table.table("control"), ControlOptions)
    output = record_of(RunOutput, table.table("output"))
    refuse_other_folders(table.table("output"), output, file.parent)
    refuse_what_cannot_run(table, plan)
    return SceneFile(plan=plan, options=options, control=control, output=output)


def _scene(table: Table) -> Scene:
    materials = table.table("materials")
    known = {name: record_of(Material, materials.table(name)) for name in materials}
    if "character" not in table:
        table.fail("the table [character] is missing")
    first = body_of(table.table("character"), known)
    world = table.table("world")
    world.only(WORLD)
    bodies = [body_of(each, known, CONTROLLER) for each in table.tables("bodies")]
    moved = [mover_of(each) for each in table.tables("movers")]
    _refuse_one_name_twice(
        [table.table("character"), *table.tables("bodies"), *table.tables("movers")],
        [body.character.name for body in (first, *bodies, *(body for body, _ in moved))],
    )
    ground = ground_of(table.table("ground")) if "ground" in table else None
    with table.explained(), world.explained(named=True):
        still = Scene(
            character=first.character,
            others=(*bodies, *(body for body, _ in moved)),
            ground=ground,
            initial_velocity=first.velocity,
            initial_spin=first.spin,
            initial_pose=first.pose,
            **{key: world.take(key) for key in WORLD if key in world},
        )
    return _with_what_moves(still, table, tuple(handle for _, handle in moved))


def _refuse_one_name_twice(tables: list[Table], names: list[str]) -> None:
    for number, (each, name) in enumerate(zip(tables, names, strict=True)):
        if name in names[:number]:
            each.fail(
                f"two bodies of the scene have the name {name!r}; give it another 'name'",
                "name" if "name" in each else None,
            )


def _with_what_moves(scene: Scene, table: Table, moved: tuple[Handle, ...]) -> Scene:
    """A scene with pushes and handles, each of which is told apart where it is wrong.

    ``moved`` are the handles of movers, which follow the others.
    """
    pushes, handles = table.tables("pushes"), table.tables("handles")
    whole, parts = scene.whole, scene.parts
    acting = pushes_of(pushes)
    for push, each in zip(acting, pushes, strict=True):
        with each.explained():
            pushed_nodes(push.region, whole)
    held = handles_of(handles)
    for number, each in enumerate(handles):
        with each.explained():
            nodes_of_handles((*moved, *held[: number + 1]), whole, parts)
    held = (*held, *moved)
    everywhere = fields_of(table.tables("fields"))
    for field, each in zip(everywhere, table.tables("fields"), strict=True):
        if field.region is not None:
            with each.explained("region"):
                acted_on(field.region, whole, parts)
    if not (acting or held or everywhere):
        return scene
    return replace(scene, pushes=acting, handles=held, fields=everywhere)


def _others(table: Table, scene: Scene) -> dict[str, Controller]:
    """The controllers of [[bodies]], by the names of these."""
    return {
        body.character.name: controller_of(each.table(CONTROLLER), body.character)
        # movers follow the bodies
        for each, body in zip(table.tables("bodies"), scene.others, strict=False)
        if CONTROLLER in each
    }


def _options(table: Table, kind: type[Any]) -> dict[str, Any]:
    """The options that a table gives; they are checked together."""
    table.only(entry.name for entry in fields(kind))
    with table.explained():
        made = kind(**{key: table.take(key) for key in table})
    return {key: getattr(made, key) for key in table}
