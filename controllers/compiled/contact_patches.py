"""The patches of one step after another by native code, for parts of a surface that stay."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.device.host_program import HostProgram
from warp_softbody.kernels.control.contact_patches import (
    COUNTS,
    NUMBERS,
    PatchSizes,
    make_contact_patches,
)

Integers = npt.NDArray[np.integer]


class SparseRows(NamedTuple):
    """Rows of a sparse matrix: where each begins and ends, columns and values."""

    begins: Integers
    columns: Integers
    values: FloatArray


class StayingParts(NamedTuple):
    """What stays of parts of a surface, given by their nodes part after part.

    Attributes:
        node_count: of all bodies.
        nodes: (k,), of the first part, then of the next.
        begins: (p,), where in them each part begins.
        faces: (f, 3), nodes of the triangles around them.
        around: rows (k,) of these faces; values do not matter.
        nearest: (3, own), what takes the character's positions to the axes that it carries.
        carrier: rows (k,), what takes positions to the direction that a node carries; None for
            a character whose friction has none.
        node_factors: (k, 8), on the friction by direction; not looked at without ``carrier``.
        plane: normal and offset (4,) of the ground; None where it is none.
        scalars: reach (m), impulse (N s) and speed (m/s) of the quadrature and the frames.
    """

    node_count: int
    nodes: Integers
    begins: Integers
    faces: Integers
    around: SparseRows
    nearest: FloatArray
    carrier: SparseRows | None
    node_factors: FloatArray
    plane: FloatArray | None
    scalars: tuple[float, float, float]


class PatchNumbers(NamedTuple):
    """Of p patches: weights (p, n), gaps (p,), areas (p,), frames (p, 3, 3), factors (p, 8)."""

    weights: FloatArray
    gaps: FloatArray
    areas: FloatArray
    frames: FloatArray
    factors: FloatArray
    touching: list[int]


class CompiledPatches:
    """Finds the patches of parts that stay, with numbers as the NumPy form has them.

    Attributes:
        nodes: (k,), of the parts.
    """

    def __init__(self, parts: StayingParts) -> None:
        """Lay out the arrays of some parts."""
        carried = 0 if parts.carrier is None else len(parts.carrier.columns)
        sizes = PatchSizes(
            *(parts.node_count, parts.nearest.shape[1], len(parts.nodes), len(parts.begins)),
            *(len(parts.faces), len(parts.around.columns), carried),
            flat=int(parts.plane is not None),
        )
        numbers = {name: shape(sizes) for name, shape in NUMBERS.items()}
        counts = {name: shape(sizes) for name, shape in COUNTS.items()}
        program = HostProgram(numbers, counts)
        self.nodes = parts.nodes
        self._numbers, self._counts = program.numbers, program.counts
        self._run = program.running(make_contact_patches().find, reads=[], writes=[])
        self._counts["settings"][...] = sizes
        for name in ("nodes", "faces"):
            self._counts[name][...] = getattr(parts, name)
        self._counts["begins"][...] = (*parts.begins.tolist(), len(parts.nodes))
        self._counts["face_begins"][...] = parts.around.begins
        self._counts["faces_around"][...] = parts.around.columns
        self._numbers["nearest"][...] = parts.nearest
        self._numbers["scalars"][...] = parts.scalars
        if parts.plane is not None:
            self._numbers["plane"][...] = parts.plane
        if parts.carrier is not None:
            self._counts["carrier_begins"][...] = parts.carrier.begins
            self._counts["carrier_nodes"][...] = parts.carrier.columns
            self._numbers["carrier"][...] = parts.carrier.values
            self._numbers["node_factors"][...] = parts.node_factors

    def find(
        self,
        positions: FloatArray,
        velocities: FloatArray,
        impulses: FloatArray,
        touching: BoolArray,
        ground: tuple[FloatArray, FloatArray] | None,
    ) -> PatchNumbers:
        """The patches.

        Args:
            positions: (n, 3) m.
            velocities: (n, 3) m/s.
            impulses: (n, 3) N s, of the ground in the last step.
            touching: (n,), nodes that bore one.
            ground: distances (k,) m of the parts' nodes from the ground and its normals (k, 3)
                there; None for a plane.
        """
        numbers, counts = self._numbers, self._counts
        numbers["positions"][...] = positions
        numbers["velocities"][...] = velocities
        numbers["impulses"][...] = impulses
        counts["touching"][...] = touching
        if ground is not None:
            numbers["gaps"][...], numbers["normals"][...] = ground
        self._run()
        return PatchNumbers(
            weights=numbers["weights"].copy(),
            gaps=numbers["patch_gaps"].copy(),
            areas=numbers["areas"].copy(),
            frames=numbers["frames"].copy(),
            factors=numbers["factors"].copy(),
            touching=counts["patch_touches"].tolist(),
        )
