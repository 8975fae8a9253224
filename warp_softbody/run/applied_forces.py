"""Forces that a script or a person applies while a simulation runs, beside the scene's pushes."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.engine.model import Model
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks, input_kinds

IntArray = npt.NDArray[np.int32]


class AppliedForce:
    """A force on some nodes that acts in every step until it is changed or removed.

    `Simulation.apply_force` makes it.

    Attributes:
        nodes: (k,) int32, ascending, that it acts on.
        shares: (k,) of each of them, adding up to one.
    """

    def __init__(self, nodes: IntArray, shares: FloatArray, force: object) -> None:
        """Apply a force, N, to nodes by their shares."""
        self.nodes = nodes
        self.shares = shares
        self._force = (0.0, 0.0, 0.0)
        self.force = force  # type: ignore[assignment]

    @property
    def force(self) -> tuple[float, float, float]:
        """The total force, N, (x, y, z); what is set acts from the next step on."""
        return self._force

    @force.setter
    def force(self, force: tuple[float, float, float]) -> None:
        x, y, z = checks.vector("force of an AppliedForce", force, unit="N")
        self._force = (x, y, z)

    def remove(self) -> None:
        """Let it act no more; another force may be set later."""
        self._force = (0.0, 0.0, 0.0)

    @property
    def acts(self) -> bool:
        """Whether it is other than zero."""
        return any(self._force)

    def add_to(self, forces: FloatArray) -> None:
        """Add its share of each node to forces (n, 3) N."""
        forces[self.nodes] += np.outer(self.shares, self._force)

    def __repr__(self) -> str:
        """Force and number of nodes."""
        return f"AppliedForce(force={self._force}, nodes={len(self.nodes)})"


def applied_force(model: Model, nodes: object, force: object, weights: object) -> AppliedForce:
    """The force that arguments of `Simulation.apply_force` stand for.

    Raises:
        InputError: they do not name nodes, or are no finite numbers.
    """
    if isinstance(nodes, str):
        chosen = np.asarray(model.scene.whole.region(nodes), dtype=np.int32)
    else:
        chosen = input_kinds.node_set("nodes of apply_force", nodes, model.node_count)
    if not len(chosen):
        raise InputError("nodes of apply_force must be a region or nodes, but there is none")
    if weights is None:
        masses = model.masses[chosen]
        return AppliedForce(chosen, masses / masses.sum(), force)
    given = array_checks.array("weights of apply_force", weights, (len(chosen),))
    if (given < 0.0).any() or not (given > 0.0).any():
        raise InputError("weights of apply_force must not be negative, and not all of them zero")
    shares = given / given.max()
    return AppliedForce(chosen, shares / shares.sum(), force)
