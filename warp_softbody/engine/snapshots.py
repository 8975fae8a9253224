"""Device state as NumPy: what controllers see of a step, and what a run hands out."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.contact_mode import ContactMode
from warp_softbody.device.host_view import HostViews
from warp_softbody.engine.model import Model
from warp_softbody.engine.state import Contacts, PairStates, State
from warp_softbody.inputs.records import unchecked
from warp_softbody.kernels.contact.modes import Mode
from warp_softbody.world.frame import GROUND, ContactSample, Frame
from warp_softbody.world.view import BodyView

Touching = tuple[
    npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any]
]
"""Nodes, modes, impulses, nodes on the other side and their weights, of one kind of contact."""

LIFT = int(Mode.LIFT)

SEEN_MODES = np.array(
    [ContactMode[mode.name] for mode in (Mode.LIFT, Mode.STICK, Mode.SLIDE)], dtype=np.int32
)
"""Modes as frames show them, by those of the kernels."""


class Snapshots:
    """Copies of a model's state."""

    def __init__(self, model: Model) -> None:
        """Snapshots of a model."""
        self._model = model
        own = np.arange(model.node_count) < model.scene.parts[0].nodes.stop
        self._character_masses = np.where(own, model.masses, 0.0)
        self._names = tuple(part.name for part in model.scene.parts)
        self._bodies = model.scene.node_bodies
        self._views = HostViews()
        self._workroom: dict[Any, Any] | None = {} if model.options.native_code else None

    def view(
        self, state: State, contacts: Contacts, rest_lengths: FloatArray, time: float
    ) -> BodyView:
        """The state as a controller sees it."""
        model = self._model
        touching = np.zeros(model.node_count, dtype=bool)
        impulses = np.zeros((model.node_count, 3))
        if model.contact_count:
            chosen = self._views.read(contacts.modes) != LIFT
            nodes = model.body.mesh.surface_nodes[chosen]
            touching[nodes] = True
            impulses[nodes] = self._views.read(contacts.impulses)[chosen]
        return unchecked(
            BodyView,
            scene=model.scene,
            time=time,
            time_step=model.options.time_step,
            masses=self._character_masses,
            positions=self._doubles(state.positions),
            velocities=self._doubles(state.velocities),
            touching=touching,
            activations=self.activations(rest_lengths),
            impulses=impulses,
            workroom=self._workroom,
        )

    def frame(
        self,
        index: int,
        time: float,
        state: State,
        contacts: Contacts,
        rest_lengths: FloatArray,
        planned: ContactSample,
    ) -> Frame:
        """The state as a run hands it out."""
        positions = self._doubles(state.positions)
        layout = self._model.muscles
        points = np.einsum("pk,pka->pa", layout.point_weights, positions[layout.point_nodes])
        return Frame(
            index=index,
            time=time,
            positions=positions,
            velocities=self._doubles(state.velocities),
            activations=self.activations(rest_lengths),
            fiber_points=points,
            contacts=self._touching(contacts, positions),
            patches=planned,
        )

    def activations(self, rest_lengths: FloatArray) -> FloatArray:
        """(segments,) l_d / l_0 of rest lengths, m; 1 where a segment is slack."""
        rest = self._model.muscles.rest_lengths
        return np.minimum(rest_lengths / rest, 1.0) if len(rest) else np.zeros(0)

    def _touching(self, contacts: Contacts, positions: FloatArray) -> ContactSample:
        found = [self._on_ground(contacts)] if self._model.contact_count else []
        if contacts.pairs is not None:
            found.append(self._on_surfaces(contacts.pairs))
        if not found:
            return ContactSample(names=self._names)
        nodes, modes, impulses, others, weights = map(np.concatenate, zip(*found, strict=True))
        partners = np.where(others[:, 0] >= 0, self._bodies[others[:, 0]], GROUND)
        return ContactSample(
            nodes=nodes.astype(np.int32),
            points=positions[nodes],
            # the places of a polygon of friction are all sliding
            modes=SEEN_MODES[np.minimum(modes, Mode.SLIDE)],
            forces=impulses.astype(np.float64) / self._model.options.time_step,
            bodies=self._bodies[nodes],
            partners=partners.astype(np.int32),
            partner_nodes=others.astype(np.int32),
            partner_weights=weights.astype(np.float64),
            names=self._names,
        )

    def _on_ground(self, contacts: Contacts) -> Touching:
        modes = self._views.read(contacts.modes)
        chosen = modes != LIFT
        nodes = self._model.body.mesh.surface_nodes[chosen]
        others = np.full((len(nodes), 3), -1)
        impulses = self._views.read(contacts.impulses)[chosen]
        return nodes, modes[chosen], impulses, others, 0.0 * others

    def _on_surfaces(self, pairs: PairStates) -> Touching:
        """The nodes' pairs, then those of edges with bodies or the ground, once for either end."""
        modes = pairs.modes.numpy()
        chosen = np.flatnonzero(modes != LIFT)
        first = len(self._model.body.mesh.surface_nodes) if self._model.scene.has_pairs else 0
        edge = chosen >= first
        nodes, weights = pairs.nodes.numpy()[chosen], pairs.weights.numpy()[chosen]
        modes, impulses = modes[chosen], pairs.impulses.numpy()[chosen]
        corners, between = nodes[~edge, 1:], -weights[~edge, 1:]
        found = [(nodes[~edge, 0], modes[~edge], impulses[~edge], corners, between)]
        ends, shares = nodes[edge], weights[edge]
        column = np.zeros((len(ends), 1))
        grounded = ends[:, 2:3] == ends[:, :1]
        others = np.where(grounded, -1, ends[:, 2:])
        others = np.concatenate([others, column.astype(np.int32) - 1], axis=1)
        between = np.concatenate([-shares[:, 2:], column], axis=1)
        for end in range(2):
            borne = shares[:, end : end + 1] * impulses[edge]
            found.append((ends[:, end], modes[edge], borne, others, between))
        joined = [np.concatenate(arrays) for arrays in zip(*found, strict=True)]
        return joined[0], joined[1], joined[2], joined[3], joined[4]

    def _doubles(self, array: Any) -> FloatArray:
        return np.array(self._views.read(array), dtype=np.float64)
