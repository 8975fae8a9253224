"""Two blocks and a bar with muscles in one scene, each on a straight way of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.support.bodies import box, muscular_bar
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.world.frame import ContactSample, Frame
from warp_softbody.world.ground import Plane
from warp_softbody.world.joined_bodies import Body, placed
from warp_softbody.world.scene import Scene

# not in the order of the alphabet, which is not the order of the scene
NAMES = ("tower", "bar", "cube")
SPEEDS = {"tower": (0.1, 0.0, 0.2), "bar": (0.0, -0.3, 0.0), "cube": (-0.2, 0.1, 0.4)}
FRAMES = 5


def make_crowd() -> Scene:
    """A scene at rest."""
    tower = Character(name="tower", mesh=box((2, 2, 4), (0.2, 0.2, 0.5)))
    bar = placed(muscular_bar(), translation=(0.4, 0.0, 0.0))
    cube = Character(name="cube", mesh=box(origin=(0.8, 0.0, 0.0)), color=(0.1, 0.2, 0.7))
    return Scene(
        character=tower,
        others=(Body(character=replace(bar, color=(0.2, 0.6, 0.2))), Body(character=cube)),
        ground=Plane(friction=0.4),
    )


def moved(character: Character, points: FloatArray, time: float) -> FloatArray:
    """Points of a body at a time."""
    return np.asarray(points + time * np.array(SPEEDS[character.name]))


def frame_at(scene: Scene, index: int) -> Frame:
    """All bodies on straight ways; the first and last node of each touch, the last one twice."""
    time, bodies = index / 30.0, scene.characters
    positions = np.concatenate([moved(body, body.mesh.points, time) for body in bodies])
    fibers = [moved(body, fiber.vertices, time) for body in bodies for fiber in body.fibers]
    ends = [(p.nodes.start, p.nodes.stop - 1, p.nodes.stop - 1) for p in scene.parts]
    nodes = np.array(ends, dtype=np.int32).T.reshape(-1)[: 3 * index]
    return Frame(
        index=index,
        time=time,
        positions=positions,
        velocities=np.concatenate(
            [np.tile(SPEEDS[body.name], (len(body.mesh.points), 1)) for body in bodies]
        ),
        activations=np.linspace(1.0, 0.6, scene.whole.segment_count) ** index,
        fiber_points=np.concatenate([*fibers, np.zeros((0, 3))]),
        contacts=ContactSample(
            nodes=nodes,
            points=positions[nodes],
            modes=(1 + nodes % 2).astype(np.int32),
            forces=np.column_stack([nodes, -nodes, 1.0 + np.arange(len(nodes))]).astype(float),
        ),
    )
