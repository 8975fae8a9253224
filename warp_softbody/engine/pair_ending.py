"""How a step ends whose pairs did not settle: the launches of kernels/contact/pair_ending.py."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import warp as wp

from warp_softbody.device.launching import launch
from warp_softbody.device.structs import struct_of
from warp_softbody.engine.model import Model
from warp_softbody.engine.state import PairStates
from warp_softbody.kernels.contact.pair_ending import Round, make_pair_ending


class PairEnding:
    """Releases pairs in rounds, or scales their impulses; all launches can be captured.

    Attributes:
        rounds: (4,) int32, by `Round`.
    """

    def __init__(self, model: Model, friction: float) -> None:
        """Arrays for the pairs of a model; ``friction`` is multiplied with their factors."""
        types, count = model.types, PairStates.count(model)
        self._model = model
        self._kernels = make_pair_ending(model.options.precision)
        self._friction = friction
        self._modes = model.zeros(count, wp.int32)
        self._frictions = model.zeros(count, types.vec3)
        self._stiffness = model.zeros(count, types.mat33)
        self._without = model.zeros(model.node_count, types.vec3)
        self.rounds = model.zeros(len(Round), wp.int32)
        # what bounds the energy of a step, beside its known momentum
        self._nodes = struct_of(
            self._kernels.NodeMasses,
            model.arrays.masses,
            recovery_speed=float(model.recovery_speed),
        )

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any]) -> None:
        device = self._model.options.device
        launch(kernel, 1, inputs, outputs, device)

    def begin(self, bound: Any, pairs: PairStates) -> PairStates:
        """Launch the first choice; the states that the rounds work on.

        ``bound`` is the struct of the pairs. The caller's modes stay as they are, for the next
        step to begin with; impulses are the caller's.
        """
        outputs = [self._modes, self._frictions, self.rounds]
        inputs = [bound, self._friction, pairs.impulses]
        self._launch(self._kernels.begin_rounds, inputs, outputs)
        return replace(
            pairs,
            modes=self._modes,
            friction_forces=self._frictions,
            slip_stiffness=self._stiffness,
        )

    def prune(self, bound: Any, pairs: PairStates, largest_impulse: Any, motion: list[Any]) -> None:
        """Launch what a round takes away.

        ``motion``: velocities before the step, its known impulses, and velocities after it.
        """
        inputs = [bound, self._friction, largest_impulse, pairs.impulses]
        inputs += [self._nodes, *motion]
        self._launch(self._kernels.prune, inputs, [self._modes, self._frictions, self.rounds])

    def clip(self, bound: Any, pairs: PairStates) -> None:
        """Launch the cut of all impulses to what the laws allow."""
        self._launch(self._kernels.clip, [bound, self._friction], [pairs.impulses])

    def add_impulses(
        self, bound: Any, pairs: PairStates, part: float, known: list[Any], out: Any
    ) -> None:
        """Launch the right side with a part of the impulses; ``known`` is what else is in it."""
        inputs = [bound, part, self.rounds, pairs.impulses, *known]
        self._launch(self._kernels.add_impulses, inputs, [out])

    def keep(self, x: Any) -> None:
        """Launch the copy of the velocities without the pairs' impulses."""
        wp.copy(self._without, x)

    def end(self, bound: Any, pairs: PairStates, before: Any, right: Any, x: Any) -> None:
        """Launch the choice of how much of the impulses acts, from x with all of them."""
        inputs = [bound, self._without, self._nodes, before, right]
        self._launch(self._kernels.end, inputs, [pairs.impulses, x])
