"""What stands on the ground before the first step, in which contacts are first solved for."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.contact_mode import ContactMode
from warp_softbody.world.frame import ContactSample
from warp_softbody.world.scene import Scene

TOUCHING = 1e-6
"""Gap up to which a node stands, as a share of all bodies' largest side."""


def standing_contacts(scene: Scene, positions: FloatArray) -> ContactSample:
    """Surface nodes of positions (n, 3) m that stand on the ground, at rest, without forces yet."""
    if scene.ground is None:
        return ContactSample()
    nodes = scene.whole.mesh.surface_nodes
    gaps, _ = scene.ground.measure(positions[nodes])
    near = TOUCHING * float(np.ptp(positions, axis=0).max())
    own = nodes[gaps <= near].astype(np.int32)
    starts = [part.nodes.start for part in scene.parts]
    return ContactSample(
        nodes=own,
        points=positions[own],
        modes=np.full(len(own), int(ContactMode.STICK), dtype=np.int32),
        forces=np.zeros((len(own), 3)),
        bodies=(np.searchsorted(starts, own, side="right") - 1).astype(np.int32),
        names=tuple(character.name for character in scene.characters),
    )
