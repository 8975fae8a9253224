"""Rotations, elastic forces and the step's matrix at some positions."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import warp as wp

from warp_softbody.device.launching import launch
from warp_softbody.device.structs import struct_of
from warp_softbody.device.workspace import WorkPart, Workspace
from warp_softbody.engine.implicit_muscles import ImplicitMuscles
from warp_softbody.engine.material_parts import MaterialPart
from warp_softbody.engine.model import Model
from warp_softbody.kernels.elastic.corotated import make_elasticity
from warp_softbody.kernels.elastic.edge_lanes import edge_lanes_on
from warp_softbody.kernels.elastic.exact_volume import make_exact_volume
from warp_softbody.kernels.elastic.lanes import GROUP
from warp_softbody.kernels.elastic.node_lanes import node_lanes_on
from warp_softbody.kernels.elastic.rotation_lanes import rotation_lanes_on
from warp_softbody.kernels.elastic.smoothed import make_smoothing
from warp_softbody.kernels.elastic.smoothed_lanes import make_smoothed_lanes
from warp_softbody.kernels.elastic.smoothed_volume import make_smoothed_volume
from warp_softbody.kernels.elastic.tangent import TangentKind, make_tangent
from warp_softbody.kernels.elastic.tangent_lanes import make_tangent_lanes
from warp_softbody.kernels.elastic.tet_lanes import tet_lanes_on
from warp_softbody.kernels.elastic.volume_tangent import make_volume_tangent


@dataclass(frozen=True)
class Phase:
    """Work on ``count`` independent items; ``launch(first, last)`` launches a part of it."""

    count: int
    launch: Callable[[int, int], None]


def groups(count: int) -> int:
    """Groups of items that native code takes side by side."""
    return -(-count // GROUP)


class Assembly:
    """Work arrays of the elastic part of a step; launches are capturable.

    Attributes:
        rotations: (m,) mat33 of the tets.
        area_rows: (m,) mat33, deformed face areas for the muscles.
        values: (blocks,) mat33, the matrix M~.
        node_rotations: (n,) mat33, means over the tets around.
        impulses: (n,) vec3 N s, dt (f_x + f_e).
        momentum: (n,) vec3, M v + dt (f_x + f_e).
        muscles: those that the matrix knows; None where there are none.
    """

    def __init__(self, model: Model, workspace: Workspace) -> None:
        """Take arrays for a model out of a workspace."""
        work = workspace.part("assembly", model.allocator)
        types, n, m, options = model.types, model.node_count, model.tet_count, model.options
        self._model = model
        self._elasticity = make_elasticity(options.precision)
        muscular = model.segment_count > 0
        implicit = muscular and options.muscles == "implicit"
        self.muscles = ImplicitMuscles(model, workspace) if implicit else None
        self._muscular = int(muscular and not implicit)
        self.rotations = work.zeros(m, types.mat33)
        self.area_rows = work.zeros(m, types.mat33) if self._muscular else None
        self.values = work.zeros(len(model.topology.column), types.mat33)
        self.node_rotations = work.zeros(n, types.mat33)
        self.impulses = work.zeros(n, types.vec3)
        self.momentum = work.zeros(n, types.vec3)
        where = (options.device, options.precision)
        native = options.native_code
        self._lanes = rotation_lanes_on(*where) if native else None
        self._tet_lanes = tet_lanes_on(*where) if native else None
        self._edge_lanes = edge_lanes_on(*where) if native else None
        self._node_lanes = node_lanes_on(*where) if native else None
        # of every group of matrices that are turned side by side; no two threads share one
        self._edge_count = len(model.topology.edge_slots)
        most = max(m, n, self._edge_count)
        self._odd = work.zeros(most if self._lanes else 0, wp.int32)
        # one more than there are: native code reads vectors of three as four numbers
        self._gradients = work.zeros(4 * m + 1, types.vec3)
        self._forces = work.zeros(4 * m + 1, types.vec3)
        self._exact_volume: Any = None
        if any(part.material.volume == "exact" for part in model.materials):
            self._exact_volume = make_exact_volume(options.precision)
            self._volume_gradients = work.zeros(4 * m + 1, types.vec3)
        self._tangent: Any = None
        self._smoothing: Any = None
        self._smoothed_lanes: Any = None
        if options.tangent != "warped":
            self._tangent = make_tangent(options.precision)
            self._couplings = work.zeros(4 * m + 1, types.mat33)
            self._tangent_kind = int(TangentKind[options.tangent.upper()])
            side_by_side = self._lanes is not None and options.tangent == "conserving"
            made = make_tangent_lanes(options.precision) if side_by_side else None
            self._tangent_lanes = made
            if self._exact_volume is not None:
                self._volume_tangent = make_volume_tangent(options.precision)
                twisted = self._tangent_kind == TangentKind.EXACT
                self._twists = work.zeros(4 * m if twisted else 0, types.vec3)
        if options.elements == "smoothed":
            self._allocate_smoothing(model, work)

    def _allocate_smoothing(self, model: Model, work: WorkPart) -> None:
        types, n, m = model.types, model.node_count, model.tet_count
        self._smoothing = make_smoothing(model.options.precision)
        self._deformations = work.zeros(m, types.mat33)
        self._edge_stresses = work.zeros(self._edge_count, types.mat33)
        self._edge_rotations = work.zeros(self._edge_count, types.mat33)
        linear = any(part.material.volume == "linear" for part in model.materials)
        self._node_stresses = work.zeros(n if linear else 0, types.mat33)
        self._turned_gradients = work.zeros(16 * m if linear else 0, types.vec3)
        if self._exact_volume is not None:
            self._smoothed_volume = make_smoothed_volume(model.options.precision)
            self._pressures = work.zeros(n, types.scalar)
            self._smoothed_state = struct_of(
                self._smoothed_volume.SmoothedState,
                deformations=self._deformations,
                stresses=self._edge_stresses,
                rotations=self._edge_rotations,
                pressures=self._pressures,
            )
            if self._lanes is not None:
                made = make_smoothed_lanes(
                    model.options.precision, self._smoothed_volume.SmoothedState
                )
                self._smoothed_lanes = made

    def launch(self, positions: Any, velocities: Any, iterate: Any = None) -> None:
        """Launch all of it; ``velocities`` are those of the momentum.

        ``iterate`` are the velocities of the last Newton iteration, where there is one.
        """
        for phase in self.phases(positions, velocities, iterate):
            phase.launch(0, phase.count)

    def phases(self, positions: Any, velocities: Any, iterate: Any = None) -> list[Phase]:
        """The work in order; each phase reads what the ones before it wrote."""
        m = self._model
        tets = [Phase(m.tet_count, lambda a, b: self._tets(positions, a, b))]
        if self._smoothing is not None:
            tets = [
                Phase(m.tet_count, lambda a, b: self._deform(positions, a, b)),
                Phase(self._edge_count, self._edge_stress),
                Phase(m.node_count, self._node_stress),
                Phase(m.tet_count, self._smoothed_tets),
            ]
        edges = [Phase(self._edge_count, self._edges)]
        if self._tangent is not None:
            edges = [
                Phase(m.tet_count, lambda a, b: self._couple(positions, a, b)),
                Phase(self._edge_count, self._coupled_edges),
            ]
        if self.muscles is not None:
            moving = velocities if iterate is None else iterate
            work = self.muscles.work(positions, moving, self.values)
            edges += [Phase(count, launch_part) for count, launch_part in work]
        nodes = [Phase(m.node_count, lambda a, b: self._nodes(velocities, a, b))]
        return [*tets, *edges, *nodes]

    def _launch(
        self, kernel: Any, first: int, last: int, inputs: list[Any], outputs: list[Any]
    ) -> None:
        device = self._model.options.device
        launch(kernel, last - first, inputs, outputs, device)

    def _body(self, a: int, b: int) -> list[Any]:
        mesh = self._model.arrays.mesh
        return [array[a:b] for array in (mesh.tets, mesh.rest_inverse, mesh.elastic_volume)]

    def _areas(self, a: int, b: int) -> Any:
        return None if self.area_rows is None else self.area_rows[a:b]

    def _by_body(self, kind: str, first: int, last: int) -> Iterator[tuple[MaterialPart, int, int]]:
        """The parts of a range of "tets", "edges" or "nodes" that belong to one body each."""
        for part in self._model.materials:
            own = getattr(part, kind)
            a, b = max(first, own.start), min(last, own.stop)
            if a < b:
                yield part, a, b

    def _tets(self, positions: Any, first: int, last: int) -> None:
        for part, a, b in self._by_body("tets", first, last):
            inputs = [*self._body(a, b), part.lame, self._muscular, positions]
            corners = slice(4 * a, 4 * b)
            outputs = [self.rotations[a:b], self._gradients[corners], self._areas(a, b)]
            outputs.append(self._forces[corners])
            exact, lanes = part.material.volume == "exact", self._tet_lanes
            if exact:
                outputs.append(self._volume_gradients[corners])
            if lanes is not None:
                kernel = lanes.deform_exact if exact else lanes.deform_linear
                self._launch(kernel, 0, groups(b - a), inputs, [*outputs, self._odd[a:b]])
                continue
            plain = self._exact_volume if exact else self._elasticity
            self._launch(plain.deform_tets, a, b, inputs, outputs)

    def _rotate(self, matrices: Any, a: int, b: int) -> None:
        """Turn matrices into the rotations closest to them."""
        if self._lanes is not None:
            outputs = [matrices[a:b], self._odd[a:b]]
            self._launch(self._lanes.rotate, 0, groups(b - a), [], outputs)

    def _deform(self, positions: Any, a: int, b: int) -> None:
        inputs = [*self._body(a, b), self._muscular, positions]
        outputs = [self._deformations[a:b], self.rotations[a:b], self._areas(a, b)]
        self._launch(self._smoothing.deformation_gradients, a, b, inputs, outputs)
        if self._tangent is not None:
            self._rotate(self.rotations, a, b)

    def _edge_stress(self, first: int, last: int) -> None:
        arrays = self._model.arrays
        for part, a, b in self._by_body("edges", first, last):
            around = [arrays.gather.edge_start[a : b + 1], arrays.gather.edge_corners]
            inputs = [*around, arrays.mesh.elastic_volume, self._deformations]
            found = [self._edge_stresses[a:b], self._edge_rotations[a:b]]
            means = self._smoothed_lanes or self._smoothing
            self._launch(means.mean_edges, a, b, inputs, found)
            self._rotate(self._edge_rotations, a, b)
            inputs = [part.lame, int(self._lanes is not None)]
            self._launch(self._smoothing.stress_edges, a, b, inputs, found)

    def _node_stress(self, first: int, last: int) -> None:
        arrays = self._model.arrays
        for part, a, b in self._by_body("nodes", first, last):
            around = [arrays.gather.node_start[a : b + 1], arrays.gather.node_corners]
            inputs = [*around, arrays.mesh.elastic_volume, part.lame]
            turned = int(self._lanes is not None)
            rotations = self.node_rotations[a:b]
            if part.material.volume == "exact":
                outputs = [self._pressures[a:b], rotations]
                if self._smoothed_lanes is not None:
                    kernel = self._smoothed_lanes.press_nodes
                    self._launch(kernel, a, b, [*inputs, self._deformations], outputs)
                else:
                    inputs += [turned, self._deformations]
                    self._launch(self._smoothed_volume.press_nodes, a, b, inputs, outputs)
                self._rotate(self.node_rotations, a, b)
            else:
                outputs = [self._node_stresses[a:b], rotations]
                kernel = self._smoothing.stress_nodes
                self._launch(kernel, a, b, [*inputs, self._deformations], outputs)

    def _smoothed_tets(self, first: int, last: int) -> None:
        for part, a, b in self._by_body("tets", first, last):
            tets, *rest = self._body(a, b)
            structure = [tets, self._model.arrays.gather.tet_edges[a:b], *rest]
            corners = slice(4 * a, 4 * b)
            outputs = [self.rotations[a:b], self._gradients[corners]]
            if part.material.volume == "exact":
                found = [self._volume_gradients[corners], self._forces[corners]]
                if self._smoothed_lanes is not None and self._tangent is not None:
                    inputs = [*structure, a, self._smoothed_state, outputs[0]]
                    found = [outputs[1], *found]
                    self._launch(self._smoothed_lanes.smoothed_tets, a, b, inputs, found)
                    continue
                own, turned = int(self._tangent is not None), int(self._lanes is not None)
                inputs = [*structure, own, turned, a, self._smoothed_state]
                outputs += found
                self._launch(self._smoothed_volume.smoothed_tets, a, b, inputs, outputs)
                continue
            stresses = [self._edge_stresses, self._edge_rotations, self._node_stresses]
            inputs = [*structure, *stresses, self.node_rotations]
            outputs += [self._turned_gradients[16 * a : 16 * b], self._forces[corners]]
            self._launch(self._smoothing.smoothed_tets, a, b, inputs, outputs)

    def _edge_inputs(self, part: MaterialPart, a: int, b: int) -> list[Any]:
        arrays = self._model.arrays
        around = [arrays.gather.edge_start[a : b + 1], arrays.gather.edge_corners]
        material = [part.lame, part.step_factors]
        return [*around, arrays.gather.edge_slots[a:b], *material, self._gradients]

    def _each_edge(self, kernel: Any, first: int, last: int, *more: Any) -> None:
        for part, a, b in self._by_body("edges", first, last):
            inputs = [*self._edge_inputs(part, a, b), *more]
            self._launch(kernel, a, b, inputs, [self.values])

    def _edges(self, first: int, last: int) -> None:
        lanes = self._edge_lanes
        for part, a, b in self._by_body("edges", first, last):
            if part.material.volume == "exact":
                kernel = lanes.exact if lanes else self._exact_volume.stiffness_edges
                self._each_edge(kernel, a, b, self._volume_gradients)
            elif self._smoothing is not None:
                self._each_edge(self._smoothing.smoothed_edges, a, b, self._turned_gradients)
            else:
                kernel = lanes.linear if lanes else self._elasticity.stiffness_edges
                self._each_edge(kernel, a, b)

    def _couple(self, positions: Any, first: int, last: int) -> None:
        for part, a, b in self._by_body("tets", first, last):
            tets, rest_inverse, _ = self._body(a, b)
            body, corners = [tets, rest_inverse, part.lame], slice(4 * a, 4 * b)
            now = [positions, self.rotations[a:b], self._gradients[corners]]
            outputs = [self._couplings[corners]]
            if part.material.volume == "exact" and self._tangent_kind == TangentKind.EXACT:
                outputs.append(self._twists[corners])
                self._launch(self._volume_tangent.couple_tets, a, b, [*body, *now], outputs)
                continue
            if self._tangent_lanes is not None:
                inputs = [*body, *now]
                self._launch(self._tangent_lanes.couple_tets, 0, groups(b - a), inputs, outputs)
                continue
            # the conserving tangent adds to the shear alone, whatever resists the volume
            inputs = [*body, self._tangent_kind, *now]
            self._launch(self._tangent.couple_tets, a, b, inputs, outputs)

    def _coupled_edges(self, first: int, last: int) -> None:
        conserving = self._tangent_kind == TangentKind.CONSERVING
        lanes = self._edge_lanes if conserving else None
        for part, a, b in self._by_body("edges", first, last):
            exact = part.material.volume == "exact"
            if lanes is not None and exact:
                now = [self._volume_gradients, self._couplings]
                self._each_edge(lanes.coupled_exact, a, b, *now)
            elif exact:
                *model, gradients = self._edge_inputs(part, a, b)
                now = [gradients, self._volume_gradients, self._couplings, self._twists]
                inputs = [*model, self._tangent_kind, *now]
                self._launch(self._volume_tangent.coupled_edges, a, b, inputs, [self.values])
            else:
                kernel = lanes.coupled_linear if lanes else self._tangent.coupled_edges
                self._each_edge(kernel, a, b, self._couplings)

    def _nodes(self, velocities: Any, first: int, last: int) -> None:
        arrays = self._model.arrays
        for part, a, b in self._by_body("nodes", first, last):
            around = [arrays.gather.node_start[a : b + 1], arrays.gather.node_corners]
            if self._smoothing is None:
                self._turn_nodes([*around, arrays.mesh.elastic_volume, self.rotations], a, b)
            rows = [arrays.pattern.row_start[a : b + 1], arrays.pattern.diagonal_slot[a:b]]
            step = [arrays.masses.mass[a:b], arrays.step.gravity, part.step_factors]
            inputs = [*around, *rows, *step, velocities[a:b], self._forces]
            outputs = [self.values, self.impulses[a:b], self.momentum[a:b]]
            nodes = self._node_lanes or self._elasticity
            self._launch(nodes.finish_nodes, a, b, inputs, outputs)

    def _turn_nodes(self, inputs: list[Any], a: int, b: int) -> None:
        """Launch the rotations closest to the means over the tets around nodes."""
        outputs = [self.node_rotations[a:b]]
        if self._node_lanes is None:
            self._launch(self._elasticity.rotate_nodes, a, b, inputs, outputs)
            return
        self._launch(self._node_lanes.mean_turns, a, b, inputs, outputs)
        self._rotate(self.node_rotations, a, b)
