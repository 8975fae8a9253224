"""Single precision where its rounding is small beside what a step changes, double elsewhere.

Positions are rounded to eps times the distance from the origin. That is a strain of so much over
the shortest edge, hence a pressure; and what the next step makes good of it is a velocity.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from warp_softbody.character import Character
from warp_softbody.mesh_geometry import shortest_edge
from warp_softbody.options import SimulationOptions
from warp_softbody.scene import Scene

EPS = float(np.finfo(np.float32).eps) / 2.0
"""Relative rounding of single precision."""

MOST_PRESSURE = 0.05
"""Pressure that rounding may make, of that of a body's weight."""

MOST_SPEED = 1e-3
"""Speed that rounding may make in a step, of what gravity does in it."""

SECONDS = 1.0
"""How far ahead, s, a body's initial velocity counts as a distance."""


def with_precision(options: SimulationOptions, scene: Scene) -> SimulationOptions:
    """The options with "auto" replaced by the precision that suits a scene."""
    if options.precision != "auto":
        return options
    return replace(options, precision=choose_precision(scene, options.time_step))


def choose_precision(scene: Scene, time_step: float) -> Literal["float32", "float64"]:
    """The cheapest precision whose rounding hides nothing in a scene at a time step, s."""
    speeds = (scene.initial_velocity, *(body.velocity for body in scene.others))
    for character, velocity in zip(scene.characters, speeds, strict=True):
        speed = float(np.linalg.norm(velocity))
        reach = float(np.abs(character.mesh.points).max()) + SECONDS * speed
        if not single_suffices(scene, character, reach, time_step):
            return "float64"
    return "float32"


def single_suffices(scene: Scene, character: Character, reach: float, time_step: float) -> bool:
    """Whether single precision does for a body as far from the origin as ``reach``, m."""
    gravity = np.asarray(scene.gravity, dtype=float)
    strength = float(np.linalg.norm(gravity))
    if strength == 0.0:
        return True
    mesh, material = character.mesh, character.material
    heights = mesh.points @ (gravity / strength)
    weight = material.density * strength * float(np.ptp(heights))
    edge = shortest_edge(mesh.points, mesh.tets)
    pressure = material.young_modulus * EPS * reach / edge
    speed = EPS * reach / (time_step + material.stiffness_damping)
    touches = scene.ground is not None or scene.has_pairs
    if touches and pressure > MOST_PRESSURE * weight:
        return False
    return speed <= MOST_SPEED * strength * time_step
