"""What a run has to answer for: momentum, energy and shape, and doubts in plain sentences."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.engine.model import Model
from warp_softbody.engine.momentum_account import Account, Shapes
from warp_softbody.engine.precision_choice import lost_in_single
from warp_softbody.engine.step_statistics import StepStatistics

MOST_MISSING = 1e-2
"""Momentum that may be missing, of all that a body exchanged in a run."""

DIVERGED = 1.0
"""Share of the momentum missing at which a run is stopped: no force explains most of it."""

NO_NUMBER = 1e300
"""What findings hold in place of what is not a finite number."""

MOST_GAINED = 1e-2
"""Energy that contact may have given to a body, of the largest that it had."""

MOST_UNSETTLED = 1e-2
"""Share of the steps that may end before their solves and contact modes have settled."""

MOST_SWELLING = 0.3
"""Change of a body's volume beyond which linear elasticity says little about it."""

MOST_SUNK = 0.02
"""Depth below the ground, of the body's size, at the end."""


@dataclass(frozen=True, kw_only=True)
class Unsettled:
    """The worst of the steps that did not settle.

    Attributes:
        time: at which it began, s.
        body: name of the one that violates its contact laws most; of both, as "a and b", where
            that is two bodies' contact with each other.
        node: its node, counted within that body; -1 for two bodies, and where contact had settled
            and the linear solve had not reached its tolerance.
        force: by how much, N.
    """

    time: float
    body: str
    node: int
    force: float


@dataclass(frozen=True, kw_only=True)
class Findings:
    """Physical quality of a run.

    Attributes:
        momentum_error: momentum that no force explains, of what was exchanged, of the worst body.
        contact_gain: energy that contact gave instead of taking, J, all bodies together.
        inverted_tets: tets that are inside out at the end.
        most_inverted: the same of the worst frame.
        volumes: least and largest volume of a body in any frame, of its rest volume.
        depth: how far a node is below the ground at the end, m.
        unsettled: the worst step that did not settle; None where all did.
        doubts: sentences about what should not be believed, each with a remedy.
    """

    momentum_error: float
    contact_gain: float
    inverted_tets: int
    most_inverted: int
    volumes: tuple[float, float]
    depth: float
    unsettled: Unsettled | None
    doubts: tuple[str, ...]


class RunAccount:
    """The steps of a run that did not settle, and what to make of its account."""

    def __init__(self, model: Model) -> None:
        """Begin with the momentum and energy of the scene's start."""
        scene = model.scene
        speeds = [velocity for velocity, _ in scene.starts]
        masses = np.array([model.masses[part.nodes].sum() for part in scene.parts])
        speed = np.linalg.norm(np.asarray(speeds, dtype=float), axis=1)
        self._model = model
        self._sizes = np.array([body_size(c.mesh.points) for c in scene.characters])
        self._momentum = masses * speed
        # at least a fall by a hundredth of the body
        fall = 0.01 * float(np.linalg.norm(scene.gravity)) * self._sizes
        self._energy = masses * np.maximum(0.5 * speed**2, fall)
        self._steps = 0
        self._bad_steps = 0
        self._stalled_steps = 0
        self._worst: Unsettled | None = None

    def note(self, statistics: StepStatistics, time: float) -> None:
        """Count a step that began at a time, s."""
        self._steps += 1
        self._stalled_steps += statistics.stalled
        if statistics.settled:
            return
        self._bad_steps += 1
        force = max(statistics.signorini, statistics.coulomb)
        if self._worst is None or force > self._worst.force:
            if statistics.worst_pair is not None:
                both = " and ".join(statistics.worst_pair)
                self._worst = Unsettled(time=time, body=both, node=-1, force=force)
            else:
                self._worst = self._named(statistics.worst_node, time, force)

    def _named(self, node: int, time: float, force: float) -> Unsettled:
        parts = self._model.scene.parts
        for part in parts:
            if part.nodes.start <= node < part.nodes.stop:
                own = node - part.nodes.start
                return Unsettled(time=time, body=part.name, node=own, force=force)
        return Unsettled(time=time, body=parts[0].name, node=-1, force=force)

    def has_diverged(self, account: Account) -> bool:
        """Whether all bodies together have got more momentum from nowhere than from forces.

        What they do to each other cancels in the sum, so that it need not be known.
        """
        exchanged = float((self._momentum + account.exchanged).sum())
        missing = float(np.linalg.norm(account.missing.sum(axis=0)))
        return not missing < DIVERGED * max(exchanged, 1e-300)

    def _momentum_error(self, account: Account) -> float:
        """Largest share of the momentum exchanged that is missing, over the bodies."""
        exchanged = self._momentum + account.exchanged
        missing = np.linalg.norm(account.missing, axis=1)
        return float((missing / np.maximum(exchanged, 1e-300)).max())

    def findings(self, account: Account, shapes: Shapes, positions: FloatArray) -> Findings:
        """What to make of it, with nodes at ``positions`` (n, 3), m, at the end."""
        momentum_error = self._momentum_error(account)
        depth, sunk = self._sunk(positions)
        gained = account.gained / np.maximum(np.maximum(self._energy, account.energy), 1e-300)
        doubts = [
            *self._doubts_of_rounding(positions),
            *self._doubts_of_shape(shapes, sunk),
            *self._doubts_of_steps(momentum_error, float(gained.max())),
        ]
        return Findings(
            momentum_error=_finite(momentum_error),
            contact_gain=_finite(account.gained.sum()),
            inverted_tets=int(shapes.inverted.sum()),
            most_inverted=int(shapes.most_inverted.max()),
            volumes=(_finite(shapes.least.min()), _finite(shapes.largest.max())),
            depth=depth,
            unsettled=self._worst,
            doubts=tuple(doubts),
        )

    def _sunk(self, positions: FloatArray) -> tuple[float, float]:
        """Largest depth below the ground, m, and of the size of the body that it belongs to."""
        scene = self._model.scene
        if scene.ground is None or not np.isfinite(positions).all():
            return 0.0, 0.0
        surface = self._model.body.mesh.surface_nodes
        # a fixed node is where the scene wants it
        surface = surface[self._model.arrays.masses.fixed.numpy()[surface] == 0]
        gaps, _ = scene.ground.measure(positions[surface])
        depth, share = 0.0, 0.0
        for part, size in zip(scene.parts, self._sizes, strict=True):
            own = (surface >= part.nodes.start) & (surface < part.nodes.stop)
            least = max(0.0, -float(gaps[own].min(initial=0.0)))
            depth, share = max(depth, least), max(share, least / size)
        return depth, share

    def _doubts_of_rounding(self, positions: FloatArray) -> Iterator[str]:
        model = self._model
        if model.options.precision != "float32":
            return
        away = np.abs(positions).max(axis=1)
        reaches = [float(away[part.nodes].max()) for part in model.scene.parts]
        lost = lost_in_single(model.scene, reaches, model.options.time_step)
        if lost is not None:
            yield f"float32 rounds away {lost}: take precision float64"

    def _doubts_of_shape(self, shapes: Shapes, sunk: float) -> Iterator[str]:
        if shapes.inverted.any():
            yield (
                f"{shapes.inverted.sum()} of {self._model.tet_count} tets are inside out at the "
                "end: take a stiffer material, a finer mesh or a smaller time step"
            )
        swelling = np.abs(shapes.volumes - 1.0)
        if not swelling.max() <= MOST_SWELLING:
            worst = int(swelling.argmax())
            yield (
                f"body {self._model.scene.parts[worst].name!r} ends at {shapes.volumes[worst]:.3g} "
                "times its volume, where linear elasticity means little: take a stiffer material, "
                "a larger Poisson's ratio or a smaller time step"
            )
        if sunk > MOST_SUNK:
            yield (
                f"a node ends {100.0 * sunk:.0f} % of its body's size below the ground: take a "
                "smaller time step or a finer surface"
            )

    def _doubts_of_steps(self, momentum_error: float, gained: float) -> Iterator[str]:
        if momentum_error > MOST_MISSING:
            yield (
                f"{100.0 * momentum_error:.2g} % of the momentum that a body exchanged is "
                "unexplained: take precision float64 or a smaller tolerance"
            )
        if gained > MOST_GAINED:
            yield (
                f"contact gave a body {100.0 * gained:.2g} % of its energy instead of taking it: "
                "take a smaller time step"
            )
        if self._stalled_steps > max(1.0, MOST_UNSETTLED * self._steps):
            explicit = self._model.segment_count > 0 and self._model.options.muscles == "explicit"
            yield (
                f"Newton's method stopped short in {self._stalled_steps} of {self._steps} steps, "
                "as no part of its step came nearer to the solution: take "
                f"{'implicit muscles or ' if explicit else ''}a smaller time step"
            )
        if self._bad_steps > max(1.0, MOST_UNSETTLED * self._steps):
            yield (
                f"{self._bad_steps} of {self._steps} steps ended before they had settled: take a "
                "smaller time step, or more max_contact_passes"
            )


def _finite(value: float) -> float:
    """A number that JSON can hold; what is none, or infinite, becomes ``NO_NUMBER``."""
    return float(value) if np.isfinite(value) else NO_NUMBER


def body_size(points: FloatArray) -> float:
    """Diagonal of the box around points (n, 3), m."""
    return float(np.linalg.norm(np.ptp(points, axis=0)))
