"""Device state as NumPy: what controllers see of a step, and what a run hands out."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.frame import ContactMode, ContactSample, Frame
from warp_softbody.model import Model
from warp_softbody.state import Contacts, PairStates, State
from warp_softbody.view import BodyView

FloatArray = npt.NDArray[np.float64]


class Snapshots:
    """Copies of a model's state."""

    def __init__(self, model: Model) -> None:
        """Snapshots of a model."""
        self._model = model
        own = np.arange(model.node_count) < model.scene.parts[0].nodes.stop
        self._character_masses = np.where(own, model.masses, 0.0)

    def view(
        self, state: State, contacts: Contacts, rest_lengths: FloatArray, time: float
    ) -> BodyView:
        """The state as a controller sees it."""
        model = self._model
        touching = np.zeros(model.node_count, dtype=bool)
        if model.contact_count:
            touching[model.body.mesh.surface_nodes] = contacts.modes.numpy() != ContactMode.LIFT
        return BodyView(
            scene=model.scene,
            time=time,
            time_step=model.options.time_step,
            masses=self._character_masses,
            positions=_doubles(state.positions),
            velocities=_doubles(state.velocities),
            touching=touching,
            activations=self._activations(rest_lengths),
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
        positions = _doubles(state.positions)
        layout = self._model.muscles
        points = np.einsum("pk,pka->pa", layout.point_weights, positions[layout.point_nodes])
        return Frame(
            index=index,
            time=time,
            positions=positions,
            velocities=_doubles(state.velocities),
            activations=self._activations(rest_lengths),
            fiber_points=points,
            contacts=self._touching(contacts, positions),
            patches=planned,
        )

    def _activations(self, rest_lengths: FloatArray) -> FloatArray:
        rest = self._model.muscles.rest_lengths
        return np.minimum(rest_lengths / rest, 1.0) if len(rest) else np.zeros(0)

    def _touching(self, contacts: Contacts, positions: FloatArray) -> ContactSample:
        surface = self._model.body.mesh.surface_nodes
        states: list[Contacts | PairStates] = [contacts] if self._model.contact_count else []
        states += [contacts.pairs] if contacts.pairs is not None else []
        modes = np.concatenate([state.modes.numpy() for state in states] or [np.zeros(0, int)])
        impulses = np.concatenate([s.impulses.numpy() for s in states] or [np.zeros((0, 3))])
        chosen = modes != ContactMode.LIFT
        nodes = np.tile(surface, len(states))[chosen]
        return ContactSample(
            nodes=nodes.astype(np.int32),
            points=positions[nodes],
            # the places of a polygon of friction are all sliding
            modes=np.minimum(modes[chosen], ContactMode.SLIDE).astype(np.int32),
            forces=impulses[chosen].astype(np.float64) / self._model.options.time_step,
        )


def _doubles(array: Any) -> FloatArray:
    return np.array(array.numpy(), dtype=np.float64)
