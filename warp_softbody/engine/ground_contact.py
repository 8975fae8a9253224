"""Contact of the surface nodes with the ground: its planes, constraints and active set."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt
import warp as wp

from warp_softbody.device.host_view import HostView
from warp_softbody.device.launching import launch
from warp_softbody.device.structs import struct_of
from warp_softbody.engine.assembly import Assembly
from warp_softbody.engine.contact_arrays import PassRecord
from warp_softbody.engine.friction_cone import active_set_of
from warp_softbody.engine.ground_detection import make_detection
from warp_softbody.engine.model import Model
from warp_softbody.engine.placed_friction import PlacedFriction
from warp_softbody.engine.state import Contacts, State
from warp_softbody.kernels.contact.pass_conclusion import make_pass_conclusion
from warp_softbody.kernels.contact.structs import make_contact_structs
from warp_softbody.linear.pcg import ConjugateGradients


class GroundContact:
    """Launches for the contacts with the ground; all of them can be captured.

    Without a ground there are no contacts, and only fixed nodes are held.

    Attributes:
        handled: (n,) vec3 m/s, velocities of the step that handles give; (0,) without handles.
        largest_violations: (1,) vec2 N s, by how much Signorini's and Coulomb's laws are missed
            most after a pass; pairs write their own on top of the ground's.
    """

    def __init__(self, model: Model, assembly: Assembly, solver: ConjugateGradients) -> None:
        """Arrays for the contacts of a model; ``solver`` solves with the matrix of ``assembly``."""
        precision, count = model.options.precision, model.contact_count
        self._model = model
        self._assembly = assembly
        self._solver = solver
        self._kernels = active_set_of(model)
        self._conclude = make_pass_conclusion(precision).conclude_ground
        self._detection = make_detection(model)
        self._placed = PlacedFriction.of(model)
        structs = self._structs = make_contact_structs(precision)
        record = PassRecord.of(count, model.allocator)
        self._record = struct_of(structs.PassRecord, record)
        self.handled = model.zeros(model.handled_count, model.types.vec3)
        self._planes = struct_of(
            structs.ContactPlanes,
            normals=solver.normals,
            normal_velocity=model.zeros(count, model.types.scalar),
        )
        self._ground = self._make_ground()
        pair = wp.types.vector(length=2, dtype=model.types.scalar)
        self.largest_violations = model.zeros(1, pair)
        self._worst = model.zeros(1, wp.int32)
        self._read_violations = HostView(self.largest_violations).read

    def _make_ground(self) -> Any:
        """The struct of the contacts' constants; None without a ground."""
        arrays, options = self._model.arrays, self._model.options
        if arrays.ground is None:
            return None
        placed = self._placed
        return struct_of(
            self._structs.GroundContacts,
            arrays.ground,
            friction=arrays.ground.friction if placed is None else placed.coefficients,
            fixed=arrays.masses.fixed,
            tolerances=struct_of(self._structs.Tolerances, arrays.ground.tolerances),
            max_passes=options.max_contact_passes,
        )

    def _launch(self, kernel: Any, dim: int, inputs: list[Any], outputs: list[Any]) -> None:
        launch(kernel, dim, inputs, outputs, self._model.options.device)

    def detect(self, state: State) -> None:
        """Launch the contact planes of a step from ``state`` on, and friction given by place."""
        if self._detection is not None:
            self._detection.launch(state, self._planes.normal_velocity, self._planes.normals)
        if self._placed is not None:
            self._placed.launch(state)

    def impose(self, contacts: Contacts, change: Any) -> None:
        """Launch the velocity constraints of the modes, and the velocities that they give.

        ``change`` (n,) vec3 m/s is what is added to the velocities before the step.
        """
        m, solver, k = self._model, self._solver, self._kernels
        fixed = m.arrays.masses.fixed
        if self._ground is not None:
            inputs = [self._ground.nodes, fixed, self._planes, contacts.modes, solver.before]
            outputs = [solver.kinds, solver.axes, change]
            self._launch(k.impose, m.contact_count, inputs, outputs)
        inputs = [fixed, self.handled, solver.before]
        self._launch(k.hold_fixed, m.node_count, inputs, [solver.kinds, change])

    def update(
        self, contacts: Contacts, right: Any, velocity_update: Any, right_with_slip: Any
    ) -> None:
        """Launch impulses, and the modes and frictions of the next pass.

        Args:
            contacts: the caller's states.
            right: (n,) vec3 N s, known impulses, those of pairs included.
            velocity_update: struct of the velocities before the step and their change.
            right_with_slip: (n,) vec3 N s, receives ``right`` with the constant part of friction.
        """
        if self._ground is None:
            return
        solver, assembly = self._solver, self._assembly
        inputs = [self._ground, solver.rows, assembly.node_rotations, assembly.values]
        inputs += [right, velocity_update, self._planes, solver.counters, solver.scalars]
        states = struct_of(self._structs.ContactStates, contacts)
        outputs = [states, right_with_slip, self._record]
        self._launch(self._kernels.update_modes, self._model.contact_count, inputs, outputs)

    def conclude(self, contacts: Contacts) -> None:
        """Launch the count of what a pass changed, and whether another is due."""
        inputs = [self._model.options.max_contact_passes, contacts.modes, self._record]
        outputs = [self._solver.counters, self.largest_violations, self._worst]
        self._launch(self._conclude, 1, inputs, outputs)

    def read_violations(self) -> npt.NDArray[Any]:
        """(2,) N s, the largest violations of the last pass."""
        violations: npt.NDArray[Any] = self._read_violations()[0]
        return violations

    def worst_node(self) -> int:
        """The node that missed its laws most in the last pass; -1 without a ground."""
        if not self._model.contact_count:
            return -1
        return int(self._model.body.mesh.surface_nodes[int(self._worst.numpy()[0])])
