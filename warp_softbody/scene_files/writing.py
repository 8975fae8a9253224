"""A scene is written as a file that gives the same scene, to the last bit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from warp_softbody import characters
from warp_softbody.atomic_files import replace_text
from warp_softbody.body.character import Character
from warp_softbody.errors import InputError, OutputError
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.inputs.records import same
from warp_softbody.scene_files.beside import Beside
from warp_softbody.scene_files.grounds import table_of_ground
from warp_softbody.scene_files.motions import table_of_controller
from warp_softbody.scene_files.moving import table_of_field, table_of_handle
from warp_softbody.scene_files.reading import EXTENSION, TIME_STEP, WORLD
from warp_softbody.scene_files.records import table_of
from warp_softbody.scene_files.scene_file import RunOutput, SceneFile
from warp_softbody.scene_files.toml_text import toml_text
from warp_softbody.scenes.plan import ScenePlan
from warp_softbody.world.joined_bodies import Body
from warp_softbody.world.scene import Scene

FIRST_LINE = "# A scene of warp-softbody; docs/scene-files.md has all keys.\n\n"


def write_scene_file(path: str | Path, content: SceneFile | ScenePlan) -> None:
    """Write a scene, with its controller and options, and what it needs in a folder beside it.

    Args:
        path: ends in .toml; meshes and grounds go to ``NAME_files/``.
        content: a plan, such as `scenes.make` returns, or one with options and output.

    Raises:
        InputError: the path has another ending, or the scene holds what no file can.
        OutputError: the folder cannot be written in.
    """
    file = input_kinds.path("path of a scene file", path)
    if file.suffix.lower() != EXTENSION:
        raise InputError(f"{file}: a scene file must end in {EXTENSION}")
    if isinstance(content, ScenePlan):
        content = SceneFile(plan=content, options={"time_step": content.time_step})
    beside = Beside(file)
    tables = _tables(checks.instance("content of a scene file", content, SceneFile), beside)
    try:
        beside.write()
        replace_text(file, FIRST_LINE + toml_text(tables))
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(f"{file}: cannot be written: {error.strerror or error}") from error


def _tables(content: SceneFile, beside: Beside) -> dict[str, Any]:
    plan = content.plan
    scene = plan.scene
    first = Body(
        character=scene.character,
        velocity=scene.initial_velocity,
        spin=scene.initial_spin,
        pose=scene.initial_pose,
    )
    options = dict(content.options)
    if plan.time_step != TIME_STEP:
        options.setdefault("time_step", plan.time_step)
    found: dict[str, Any] = {
        "name": plan.name,
        "description": plan.description,
        "seconds": plan.seconds,
        "world": _world(scene),
        "ground": None if scene.ground is None else table_of_ground(scene.ground, beside),
        "character": _body(first, beside),
        "bodies": [_other(plan, body, beside) for body in scene.others],
        "pushes": [table_of(push, whole=True) for push in scene.pushes],
        "handles": [table_of_handle(handle) for handle in scene.handles],
        "fields": [table_of_field(field) for field in scene.fields],
        "controller": None if plan.controller is None else table_of_controller(plan.controller),
        "options": options,
        "control": dict(content.control),
        "output": table_of(content.output, base=RunOutput()),
    }
    return {key: value for key, value in found.items() if value not in (None, [], {})}


def _other(plan: ScenePlan, body: Body, beside: Beside) -> dict[str, Any]:
    """A further body, with its controller."""
    controller = plan.others.get(body.character.name)
    own = {} if controller is None else {"controller": table_of_controller(controller)}
    return _body(body, beside) | own


def _world(scene: Scene) -> dict[str, Any]:
    defaults = {entry.name: entry.default for entry in fields(Scene)}
    found = {key: getattr(scene, key) for key in WORLD}
    return {key: value for key, value in found.items() if not same(value, defaults[key])}


def _body(body: Body, beside: Beside) -> dict[str, Any]:
    character = body.character
    found = _of_shipped(character)
    if found is None:
        found = {"file": beside.character(character)}
    if body.pose is not None:
        found["pose"] = beside.array(f"{character.name}_pose.npy", body.pose)
    still = {"velocity": body.velocity, "spin": body.spin}
    return found | {key: value for key, value in still.items() if any(value)}


def _of_shipped(character: Character) -> dict[str, Any] | None:
    """What makes a character of a shipped one of the same mesh; None where there is none."""
    for shape in characters.names():
        make = getattr(characters, shape)
        coarse: Mapping[str, Any]
        for coarse in ({}, {"coarse": 1}, {"coarse": 2}):
            try:
                base = make(**coarse)
            except (InputError, TypeError):
                break
            if same(base.mesh.points, character.mesh.points) and same(
                base.mesh.tets, character.mesh.tets
            ):
                changes = _changes(base, character)
                return None if changes is None else {"shape": shape, **coarse, **changes}
    return None


def _changes(base: Character, character: Character) -> dict[str, Any] | None:
    """The keys that turn one character into another; None where it takes more than keys can."""
    found: dict[str, Any] = {}
    for name in ("name", "color"):
        if getattr(base, name) != getattr(character, name):
            found[name] = getattr(character, name)
    if base.material != character.material:
        found["material"] = table_of(character.material, base=base.material)
    strengths = {group.name: group.strength for group in character.muscles}
    like = replace(
        base,
        name=character.name,
        color=character.color,
        material=character.material,
        fixed=character.fixed,
        regions={**base.regions, **character.regions},
        directional_friction=character.directional_friction,
        materials=character.materials,
        muscles=tuple(
            replace(group, strength=strengths.get(group.name, group.strength))
            for group in base.muscles
        ),
    )
    if like != character:
        return None
    old = {group.name: group.strength for group in base.muscles}
    if strengths != old:
        found["strengths"] = {name: s for name, s in strengths.items() if s != old[name]}
    regions = {
        name: nodes
        for name, nodes in character.regions.items()
        if not same(nodes, base.regions.get(name, np.zeros(0)))
    }
    if regions:
        found["regions"] = regions
    if character.materials:
        found["materials"] = {
            name: table_of(own, base=character.material)
            for name, own in character.materials.items()
        }
    if not same(base.fixed, character.fixed):
        found["fixed"] = character.fixed
    if base.directional_friction != character.directional_friction:
        found["directional_friction"] = [table_of(f) for f in character.directional_friction]
    return found
