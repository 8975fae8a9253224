"""Handles of a scene as velocities of its nodes, step by step."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.device.host_view import HostViews
from warp_softbody.engine.model import Model
from warp_softbody.engine.state import Control, State


class HandleMotion:
    """Writes the velocities that take held nodes to where their paths are at a step's end.

    Attributes:
        aside: (k, 3) or (1, 3) m of each handle: by how much its nodes go beside its path.
        holds: of each handle, whether it held its nodes in the last step.
    """

    def __init__(self, model: Model) -> None:
        """Of the scene of a model."""
        self._model = model
        scene, points = model.scene, model.body.mesh.points
        self._handles = tuple(
            (handle.path, nodes, points[nodes])
            for handle, nodes in zip(scene.handles, scene.handle_nodes, strict=True)
        )
        self.aside: tuple[FloatArray, ...] = tuple(np.zeros((1, 3)) for _ in self._handles)
        self._views = HostViews()
        self.holds = tuple(True for _ in self._handles)
        self._held = np.zeros(model.held_count, np.int32)

    def go_on_from(self, state: State, time: float) -> None:
        """Keep to nodes that stand aside of their paths at a time, s: they go beside them."""
        positions = self._positions(state)
        found = []
        for path, nodes, rest in self._handles:
            aside = positions[nodes] - path.places(rest, time)
            # what rounding leaves is no distance, and is to be mended in the next step
            near = np.finfo(self._model.options.precision).eps * np.abs(positions).max()
            found.append(np.where(np.abs(aside) > 16.0 * near, aside, 0.0))
        self.return_to(tuple(found), time)

    def return_to(self, aside: tuple[FloatArray, ...], time: float) -> None:
        """Go on at a time, s, with nodes that stand ``aside`` of their paths, as `aside` has it."""
        dt = self._model.options.time_step
        self.aside = aside
        self.holds = tuple(handle.holds(time - dt, dt) for handle in self._model.scene.handles)

    def apply(self, control: Control, state: State, time: float) -> bool:
        """Set the velocities of a step that begins at a time, s, and the nodes that are held in it.

        They end on the path to the last bit of the positions, so that nothing drifts. Returns
        whether any handle moves in it or has just let go.
        """
        if not self._handles:
            return False
        dt = self._model.options.time_step
        positions = self._positions(state)
        velocities = np.zeros((self._model.node_count, 3))
        handles = self._model.scene.handles
        holds = tuple(handle.holds(time, dt) for handle in handles)
        moves = holds != self.holds
        self.holds = holds
        for (path, nodes, rest), aside, held in zip(self._handles, self.aside, holds, strict=True):
            if not held:
                continue
            goal = path.places(rest, time + dt) + aside
            velocities[nodes] = (goal - positions[nodes]) / dt
            moves = moves or not np.array_equal(goal, path.places(rest, time) + aside)
        self._views.write(control.handled, velocities)
        if len(self._held):
            self._note_held(control)
        return moves

    def _note_held(self, control: Control) -> None:
        """Tell a control which nodes are held."""
        scene = self._model.scene
        self._held[:] = 0
        self._held[scene.whole.fixed] = 1
        for (_, nodes, _), held in zip(self._handles, self.holds, strict=True):
            if held:
                self._held[nodes] = 1
        self._views.write(control.held, self._held)

    def _positions(self, state: State) -> FloatArray:
        return np.asarray(self._views.read(state.positions), dtype=np.float64)
