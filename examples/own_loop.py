"""A loop of one's own: the model is constant, two states belong to the caller and are swapped.

Letter I without muscles falls 0.1 m to the floor. No controller, no muscles: none of their work.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

import warp_softbody as wsb

FALL = 0.1  # m


def main(seconds: float = 1.0, time_step: float = 0.005) -> npt.NDArray[np.float64]:
    """Height of the lowest node above the floor, m, after each step."""
    letter = replace(wsb.characters.letter_i(), muscles=())
    scene = wsb.Scene(character=letter, ground=wsb.Plane(friction=0.8, offset=-FALL))
    model = wsb.build_model(scene, wsb.SimulationOptions(time_step=time_step))
    stepper = wsb.Stepper(model)
    control, contacts = wsb.Control.slack(model), wsb.Contacts.none(model)
    before, after = wsb.State.at_rest(model), wsb.State.at_rest(model)
    heights = []
    for _ in range(round(seconds / time_step)):
        stepper.step(before, control, contacts, after)
        before, after = after, before
        heights.append(before.positions.numpy()[:, 2].min() + FALL)
    return np.array(heights)


if __name__ == "__main__":
    for index, height in enumerate(main()[::10]):
        print(f"{index / 20:5.2f} s  {1e3 * height:6.1f} mm")
