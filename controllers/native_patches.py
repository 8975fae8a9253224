"""Patches by native code: what it is told once of a surface, and what of every step."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.controllers.carried_directions import carrier_of
from warp_softbody.controllers.compiled.contact_patches import (
    CompiledPatches,
    PatchNumbers,
    SparseRows,
    StayingParts,
)
from warp_softbody.controllers.contact_frames import SLIDING, nearest_map
from warp_softbody.controllers.contact_quadrature import LOADED, REACH, surface_parts
from warp_softbody.errors import InputError
from warp_softbody.world.ground import Ground, Plane
from warp_softbody.world.view import BodyView


def nodes_of(view: BodyView, regions: tuple[str, ...]) -> list[npt.NDArray[np.int32]]:
    """Nodes of the regions of a body, of which none may be empty."""
    nodes = [view.scene.character.region(name) for name in regions]
    for name, own in zip(regions, nodes, strict=True):
        if not len(own):
            raise InputError(f"patch region {name!r} holds no nodes")
    return nodes


def native_patches(view: BodyView, ground: Ground, regions: tuple[str, ...]) -> PatchNumbers:
    """The patches of regions of a view that has a workroom."""

    def made() -> CompiledPatches:
        return CompiledPatches(_parts_that_stay(view, ground, nodes_of(view, regions)))

    known: CompiledPatches = view.kept(("patches", regions), made)
    measured = None if type(ground) is Plane else ground.measure(view.positions[known.nodes])
    return known.find(view.positions, view.velocities, view.impulses, view.touching, measured)


def _parts_that_stay(
    view: BodyView, ground: Ground, nodes: list[npt.NDArray[np.int32]]
) -> StayingParts:
    """What the native code is told once of parts of the surface."""
    character, units = view.scene.character, BodyUnits.of(view)
    known = surface_parts(character.mesh, tuple(part.tobytes() for part in nodes))
    carrier, by_node = None, character.node_friction
    if character.directional_friction:
        carrier = _rows(carrier_of(character.mesh, by_node.forward.tobytes())[known.nodes])
    plane = None
    if type(ground) is Plane:
        plane = np.array([*ground.normal, ground.offset])
    return StayingParts(
        node_count=view.node_count,
        nodes=known.nodes,
        begins=known.begins,
        faces=known.faces,
        around=_rows(sp.csr_array(known.gather)),
        nearest=nearest_map(view),
        carrier=carrier,
        node_factors=by_node.factors[known.nodes],
        plane=plane,
        scalars=(
            REACH * units.length,
            LOADED * view.weight * view.time_step,
            SLIDING * units.speed,
        ),
    )


def _rows(matrix: sp.csr_array) -> SparseRows:
    return SparseRows(matrix.indptr, matrix.indices, matrix.data)
