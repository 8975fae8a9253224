"""What would be refused only when a scene is run is refused where its file is read."""

from __future__ import annotations

import copy
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import cast

import numpy as np

from warp_softbody.controllers.controller import Controller
from warp_softbody.controllers.motions.combined import Combined
from warp_softbody.controllers.motions.sequence import Sequence
from warp_softbody.engine.muscle_layout import build_muscle_layout
from warp_softbody.errors import InputError, MeshWarning
from warp_softbody.scene_files.scene_file import FILES, RunOutput
from warp_softbody.scene_files.tables import Table
from warp_softbody.scenes.plan import ScenePlan
from warp_softbody.world.body_overlap import refuse_coincident
from warp_softbody.world.joined_bodies import Body
from warp_softbody.world.scene import Scene
from warp_softbody.world.view import BodyView


def refuse_what_cannot_run(table: Table, plan: ScenePlan) -> None:
    """Refuse muscles outside a body, bodies in one place, and controllers of other bodies.

    Raises:
        InputError: with file, line and field.
    """
    for each, body in _bodies(table, plan.scene):
        # shapes that are made in code have muscles that fit
        if "muscles" in each or "file" in each:
            with each.explained("muscles" if "muscles" in each else "file"):
                _embed_muscles(body)
    _refuse_coincident(table, plan.scene)
    if plan.controller is not None:
        first = next(_bodies(table, plan.scene))[1]
        _ask_all(table.table("controller"), plan.controller, plan, first)
    for each, body in _bodies(table, plan.scene):
        own = plan.others.get(body.character.name)
        if own is not None:
            _ask_all(each.table("controller"), own, plan, body)


def refuse_other_folders(table: Table, output: RunOutput, folder: Path) -> None:
    """Refuse files of a run whose folder is not there, or elsewhere by a link; plots make theirs.

    Raises:
        InputError: with file, line and field.
    """
    for name in FILES:
        given = getattr(output, name)
        if given is None:
            continue
        if not (folder / given).resolve().is_relative_to(folder.resolve()):
            table.fail(f"{given!r} leads out of the folder of the file by a link", name)
        if name != "plots" and not (folder / given).parent.is_dir():
            table.fail(f"there is no folder {str(Path(given).parent)!r} beside the file", name)


def _bodies(table: Table, scene: Scene) -> Iterator[tuple[Table, Body]]:
    """The bodies of a scene that have tables of their own, without movers."""
    first = Body(character=scene.character, pose=scene.initial_pose)
    yield table.table("character"), first
    # movers follow the bodies
    yield from zip(table.tables("bodies"), scene.others, strict=False)


def _embed_muscles(body: Body) -> None:
    with warnings.catch_warnings():
        # the run tells of vertices that are moved onto the surface
        warnings.simplefilter("ignore", MeshWarning)
        build_muscle_layout(body.character)


def _refuse_coincident(table: Table, scene: Scene) -> None:
    if not scene.others:
        return
    try:
        refuse_coincident(scene)
    except InputError as error:
        tables = [*table.tables("bodies"), *table.tables("movers")]
        for each, body in reversed(list(zip(tables, scene.others, strict=True))):
            if repr(body.character.name) in str(error):
                each.fail(str(error))
        raise


def _ask_all(table: Table, controller: Controller, plan: ScenePlan, body: Body) -> None:
    """Ask a controller, or all that one is composed of, each told where it stands."""
    if isinstance(controller, Sequence):
        for own, motion in zip(table.tables("motions"), controller.motions, strict=True):
            _ask_all(own, motion.controller, plan, body)
    elif isinstance(controller, Combined):
        for own, one in zip(table.tables("together"), controller.together, strict=True):
            # no file has a function in place of a controller
            _ask_all(own, cast(Controller, one), plan, body)
    else:
        with table.explained("kind"):
            _ask(controller, plan.scene, body, plan.time_step)


def _ask(controller: Controller, scene: Scene, body: Body, time_step: float) -> None:
    """Ask a copy of a controller, as one is for one run, for the goals of the first step."""
    character = body.character
    if not character.segment_count:
        # the run tells that it is never asked
        return
    points = np.array(character.mesh.points if body.pose is None else body.pose)
    view = BodyView(
        scene=Scene(character=character, ground=scene.ground, gravity=scene.gravity),
        time=0.0,
        time_step=time_step,
        masses=character.node_masses,
        positions=points,
        velocities=np.zeros_like(points),
        touching=np.zeros(len(points), dtype=bool),
        activations=np.ones(character.segment_count),
        impulses=np.zeros_like(points),
    )
    copy.deepcopy(controller).goals(view)
