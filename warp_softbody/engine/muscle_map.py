"""One step's map from rest lengths of muscles to rows of J: dt W^T A of the reduced dynamics."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from warp_softbody.device.launching import launch
from warp_softbody.device.warp_runtime import with_kernels
from warp_softbody.engine.stepper import Stepper
from warp_softbody.kernels.linear.block_lanes import SHARES
from warp_softbody.kernels.muscles import make_muscles


class MuscleMap:
    """Launches W^T dt A for blocks of responses W, at the state last assembled by a stepper."""

    def __init__(self, stepper: Stepper, lanes: SimpleNamespace | None) -> None:
        """The map of a body with muscles; ``lanes`` are the kernels for processors, if any."""
        self._stepper = stepper
        self._lanes = lanes
        self._kernels = make_muscles(stepper.model.options.precision)
        if lanes is not None:
            model, own = stepper.model, stepper.model.arrays.muscles
            found = (own.pair_segment, own.pair_weight, own.directions)
            share = lanes.share_directions
            self._shares = stepper.workspace.shared(
                "shares", (), found, lambda: self._shared(share)
            )
            muscles = stepper.assembly.muscles
            none = model.zeros(0, model.types.scalar)
            self._scales = none if muscles is None else muscles.reciprocals

    def _shared(self, share: Any) -> Any:
        """What each number of a tet's stretch adds to a segment, by pair."""
        model, own = self._stepper.model, self._stepper.model.arrays.muscles
        count = len(own.pair_segment)
        shares = model.zeros((max(1, count), SHARES), model.types.scalar)
        pairs = [own.pair_segment, own.pair_weight, own.directions]
        with_kernels(lambda: self._run(share, count, pairs, [shares]))
        return shares

    def launch(self, responses: Any, stretch: Any, maps: Any) -> None:
        """Launch the map of ``responses`` (blocks, 3n).

        It is written to ``maps`` (blocks, s), by way of the ``stretch`` of tets (blocks, 6m).
        """
        model, now = self._stepper.model, self._stepper.assembly
        a, blocks = model.arrays.muscles, len(responses)
        factors = [a.stiffness, model.arrays.step.factors]
        tet_response = (self._lanes or self._kernels).tet_response
        weights, frames = a.segment_weight, [now.rotations, now.area_rows]
        if now.muscles is not None:
            frames = [now.muscles.deformations, now.muscles.rest_rows]
            if self._lanes is None:
                weights = now.muscles.launch_weights()
        turned = int(now.muscles is not None)
        inputs = [model.arrays.mesh.tets, turned, *frames, responses]
        self._run(tet_response, (blocks, model.tet_count), inputs, [stretch])
        if self._lanes is not None:
            pairs = [a.pair_start, a.pair_segment, self._shares]
            inputs = [*pairs, *factors, self._scales, stretch]
            self._run(self._lanes.muscle_response_by_tets, blocks, inputs, [maps])
            return
        segments = [a.segment_start, a.segment_tet, weights, a.directions]
        shape = (blocks, model.segment_count)
        self._run(self._kernels.muscle_response, shape, [*segments, *factors, stretch], [maps])

    def _run(self, kernel: Any, dim: Any, inputs: list[Any], outputs: list[Any]) -> None:
        device = self._stepper.model.options.device
        launch(kernel, dim, inputs, outputs, device)
