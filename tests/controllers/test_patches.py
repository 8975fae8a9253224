"""Which nodes stand for the regions that a controller thinks of."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warp_softbody.characters import letter_i
from warp_softbody.controllers.patches import ground_patches
from warp_softbody.ground import Plane
from warp_softbody.scene import Scene
from warp_softbody.view import BodyView


def standing_on(scene: Scene, touching: npt.NDArray[np.int32]) -> BodyView:
    """A body at rest in its rest shape of which only these nodes touch."""
    points = scene.character.mesh.points
    return BodyView(
        scene=scene,
        time=0.0,
        time_step=1.0 / 60.0,
        masses=np.ones(len(points)),
        positions=np.array(points),
        velocities=np.zeros_like(points),
        touching=np.isin(np.arange(len(points)), touching),
        activations=np.ones(scene.character.segment_count),
    )


def test_patches_share_no_node() -> None:
    """Of letter I's base, whose quarters meet along lines of nodes that belong to both."""
    scene = Scene(character=letter_i(), ground=Plane())
    base = scene.character.region("base")
    names = tuple(f"base_patch_{index}" for index in range(4))
    x, y = scene.character.mesh.points[base, :2].T
    for touching in (x > -1.0, x > 0.2, (x > 0.2) & (abs(y) < 0.01), abs(x) < 0.01, x > 1.0):
        view = standing_on(scene, base[touching])
        stands = np.array([patch.weights > 0.0 for patch in ground_patches(view, names)])
        assert stands.any(axis=1).all()
        assert stands.sum(axis=0).max() == 1
        shared = [np.isin(base[touching], scene.character.region(name)) for name in names]
        of_one = base[touching][np.sum(shared, axis=0) == 1]
        assert stands[:, of_one].any(axis=0).all()
