"""A scene turned about the vertical, and its stage turned back.

Mesh, fibres, directional friction and pushes are turned. Controllers name directions of the world
(forward is x), which cannot be given to them; so a turned one is asked in its own axes: it sees the
state turned back, and its rows and contact frames are turned forth. Everything else, contact and
friction among it, is computed in the axes of the turned world.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.controllers.controller import Controller, Goals
from warp_softbody.controllers.objectives import Objective
from warp_softbody.controllers.patches import Patch
from warp_softbody.errors import InputError
from warp_softbody.scenes import ScenePlan
from warp_softbody.stage_exports.usd.reader import Take
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene
from warp_softbody.world.view import BodyView

Vector = tuple[float, float, float]


def rotation(degrees: float) -> FloatArray:
    """Matrix (3, 3) that turns about z."""
    angle = np.radians(degrees)
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def turned_plan(plan: ScenePlan, degrees: float) -> ScenePlan:
    """The same happening in a world turned about the vertical.

    Raises:
        InputError: a ground other than a level plane, bodies beside the character, or gravity that
            is not vertical.
    """
    turn = rotation(degrees)
    scene, controller = plan.scene, plan.controller
    if controller is not None:
        controller = TurnedController(controller, scene, turn)
    return replace(plan, scene=_turned_scene(scene, degrees), controller=controller)


def turned_back(take: Take, degrees: float) -> Take:
    """The take as the world before the turn would show it; contacts are left as they are."""
    turn = rotation(degrees)
    return replace(
        take,
        rest=take.rest @ turn,
        tet_points=take.tet_points @ turn,
        velocities=take.velocities @ turn,
        skin_rest=take.skin_rest @ turn,
        skin_points=take.skin_points @ turn,
        fiber_points=take.fiber_points @ turn,
    )


def turned_pushes(scene: Scene, degrees: float) -> Scene:
    """The scene with its pushes alone turned about the vertical."""
    turn = rotation(degrees)
    pushes = tuple(replace(push, force=_turned(push.force, turn)) for push in scene.pushes)
    return replace(scene, pushes=pushes)


def _turned_scene(scene: Scene, degrees: float) -> Scene:
    turn = rotation(degrees)
    level = isinstance(scene.ground, Plane) and scene.ground.normal == (0.0, 0.0, 1.0)
    if not level or scene.others or any(scene.gravity[:2]):
        raise InputError("only one body under vertical gravity on a level plane can be turned")
    return replace(
        turned_pushes(scene, degrees),
        character=_turned_character(scene.character, turn),
        initial_velocity=_turned(scene.initial_velocity, turn),
    )


def _turned_character(character: Character, turn: FloatArray) -> Character:
    muscles = tuple(
        replace(
            group,
            fibers=tuple(
                replace(fiber, vertices=fiber.vertices @ turn.T) for fiber in group.fibers
            ),
        )
        for group in character.muscles
    )
    frictions = tuple(
        replace(friction, direction=_turned(friction.direction, turn))
        for friction in character.directional_friction
    )
    mesh = replace(character.mesh, points=character.mesh.points @ turn.T)
    return replace(character, mesh=mesh, muscles=muscles, directional_friction=frictions)


def _turned(vector: Vector, turn: FloatArray) -> Vector:
    x, y, z = (turn @ np.array(vector)).tolist()
    return x, y, z


class TurnedController:
    """A controller that is asked in its own axes, in a world that is turned against them.

    Attributes:
        controllers: the one that is asked, for those who look at what controllers say.
    """

    def __init__(self, controller: Controller, scene: Scene, turn: FloatArray) -> None:
        """Show ``controller`` the ``scene`` before it was turned by the matrix ``turn`` (3, 3)."""
        self._controller = controller
        self._scene = scene
        self._turn = turn
        self.controllers = (controller,)

    def goals(self, view: BodyView) -> Goals | None:
        """What the controller wants, in the axes of the turned world."""
        own = replace(
            view,
            scene=self._scene,
            positions=view.positions @ self._turn,
            velocities=view.velocities @ self._turn,
            impulses=view.impulses @ self._turn,
        )
        goals = self._controller.goals(own)
        if goals is None:
            return None
        return replace(
            goals,
            objectives=tuple(self._objective(one) for one in goals.objectives),
            patches=tuple(self._patch(patch) for patch in goals.patches),
        )

    def _objective(self, objective: Objective) -> Objective:
        """Rows on the velocities of the turned world; targets are numbers and stay."""
        count = len(objective.rows)
        rows = objective.rows.reshape(count, -1, 3) @ self._turn.T
        return replace(objective, rows=rows.reshape(count, -1))

    def _patch(self, patch: Patch) -> Patch:
        """Its frame in the turned world, where the motion that it lies along is turned too."""
        return replace(patch, frame=patch.frame @ self._turn.T)
