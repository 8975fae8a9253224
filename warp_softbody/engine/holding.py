"""What it took to hold nodes where they were held in the last step, in NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.sparse import bsr_array

from warp_softbody.arrays import FloatArray
from warp_softbody.engine.state import Contacts
from warp_softbody.engine.stepper import Stepper
from warp_softbody.kernels.contact.modes import Mode


def holding_impulse(
    stepper: Stepper, contacts: Contacts, nodes: npt.NDArray[np.integer]
) -> FloatArray:
    """The impulse (3,) N s that something outside gave some held nodes in the last step.

    It is what their momentum changed by, M~ v+ - M v, beside all that is known to act on them:
    elasticity, muscles, weight, outer forces and contact with other surfaces.
    """
    model, contact = stepper.model, stepper.contact
    before, change, right = (_doubles(a) for a in (contact.before, contact.change, contact.right))
    topology, arrays = model.topology, model.arrays
    blocks = _doubles(stepper.assembly.values)
    matrix = bsr_array((blocks, topology.column, topology.row_start), blocksize=(3, 3))
    mass, damped = _doubles(arrays.masses.mass), _doubles(arrays.masses.damped_mass)
    # differences of velocities, as the kernels take them: of a translation the stiffness sees none
    velocities = before + change
    drift = velocities[nodes].mean(axis=0)
    taken = (matrix @ (velocities - drift).ravel()).reshape(-1, 3)
    taken += damped[:, None] * drift - mass[:, None] * before
    taken -= right + _of_pairs(contacts, model.node_count)
    return np.asarray(taken[nodes].sum(axis=0))


def _of_pairs(contacts: Contacts, count: int) -> FloatArray:
    """Impulses (n, 3) N s of surfaces on nodes, by the weights of both sides."""
    found = np.zeros((count, 3))
    if contacts.pairs is not None:
        pressed = contacts.pairs.modes.numpy() != Mode.LIFT
        owners = contacts.pairs.nodes.numpy()[pressed]
        weights = _doubles(contacts.pairs.weights)[pressed]
        impulses = _doubles(contacts.pairs.impulses)[pressed]
        np.add.at(found, owners, weights[:, :, None] * impulses[:, None])
    return found


def _doubles(array: Any) -> FloatArray:
    return np.asarray(array.numpy(), dtype=np.float64)
