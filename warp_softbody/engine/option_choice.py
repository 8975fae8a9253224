"""What "auto" stands for in the options of a scene: elements, tangent and precision.

Control must not lean on errors of the discretisation, so bodies with muscles get elements that
hardly lock, and a tangent that does not damp turns. Passive scenes model no more than they need.
"""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.engine.options import Elements, SimulationOptions, Tangent
from warp_softbody.engine.precision_choice import with_precision
from warp_softbody.world.scene import Scene


def with_choices(options: SimulationOptions, scene: Scene) -> SimulationOptions:
    """The options with every "auto" replaced by what suits a scene."""
    elements = _elements(options, scene)
    tangent = _tangent(options, scene, elements)
    if (elements, tangent) != (options.elements, options.tangent):
        options = replace(options, elements=elements, tangent=tangent)
    return with_precision(options, scene)


def _muscular(scene: Scene) -> bool:
    return any(character.muscles for character in scene.characters)


def _exact_volumes(scene: Scene) -> bool:
    return all(character.material.volume == "exact" for character in scene.characters)


def _elements(options: SimulationOptions, scene: Scene) -> Elements:
    """Smoothed for bodies with muscles, but for a tangent asked for that these lack."""
    if options.elements != "auto":
        return options.elements
    lacking = options.tangent == "exact"
    lacking |= options.tangent == "conserving" and not _exact_volumes(scene)
    return "smoothed" if _muscular(scene) and not lacking else "linear"


def _tangent(options: SimulationOptions, scene: Scene, elements: Elements) -> Tangent:
    """Conserving for bodies with muscles, where the elements have it."""
    if options.tangent != "auto":
        return options.tangent
    known = elements == "linear" or _exact_volumes(scene)
    return "conserving" if _muscular(scene) and known else "warped"
