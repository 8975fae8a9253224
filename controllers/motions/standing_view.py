"""A body at rest where it is: from this motions take the heights and places that they keep to."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_softbody.inputs.records import unchecked_copy
from warp_softbody.world.view import BodyView


class Workroom(dict[Any, Any]):
    """What native code keeps for the views of one motion; a copy of the motion begins without."""

    def __deepcopy__(self, memo: dict[int, Any]) -> Workroom:
        """One that is empty: what is kept is made again, and is the same."""
        return Workroom()


def from_its_start(view: BodyView, begun: float, workroom: Workroom) -> BodyView:
    """A view whose time is that since a motion began, at ``begun`` s.

    Motions keep what they make of the shape in a workroom of their own, so that none finds
    another's.
    """
    own = unchecked_copy(view, time=view.time - begun)
    own.__dict__["workroom"] = None if view.workroom is None else workroom
    known = view.__dict__.get("_known_momenta")
    if known is not None:
        own.__dict__["_known_momenta"] = known
    return own


def standing_view(view: BodyView) -> BodyView:
    """The rest shape with its centre of mass over that of the body, at rest on the ground there.

    Without a ground it is as high as the body is.
    """
    rest, count = view.scene.character.mesh.points, len(view.positions)
    ground = view.scene.ground
    shift = view.center_of_mass - view.masses[: len(rest)] @ rest / view.mass
    points = np.zeros((count, 3))
    points[: len(rest)] = rest + shift
    if ground is not None:
        skin = view.scene.character.mesh.surface_nodes
        up = np.asarray(ground.normal)
        # twice, as the ground may be another one further down
        for _ in range(2):
            points[: len(rest)] -= ground.measure(points[skin])[0].min() * up
    points[len(rest) :] = view.positions[len(rest) :]
    own = unchecked_copy(
        view,
        time=0.0,
        positions=points,
        velocities=np.zeros_like(points),
        touching=np.zeros(count, dtype=bool),
        impulses=np.zeros_like(view.impulses),
    )
    own.__dict__["workroom"] = view.workroom
    return own
