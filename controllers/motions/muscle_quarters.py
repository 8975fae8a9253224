"""In which quarter of a body each segment of its muscles lies: behind or ahead, below or above."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warp_softbody.world.view import BodyView


def muscle_quarters(view: BodyView) -> npt.NDArray[np.intp]:
    """Number (s,) of each segment's quarter at rest, seen from the centre of mass.

    0 behind (less x) and below, 1 behind and above, 2 ahead and below, 3 ahead and above.
    """
    character = view.scene.character
    rest = character.mesh.points
    middle = view.masses[: len(rest)] @ rest / view.mass
    fibers = [fiber.vertices for group in character.muscles for fiber in group.fibers]
    middles = np.concatenate([0.5 * (line[1:] + line[:-1]) for line in fibers])
    ahead, above = middles[:, 0] > middle[0], middles[:, 2] > middle[2]
    return np.asarray(2 * ahead + above, dtype=np.intp)
