"""What a run has to answer for: momentum, energy and shape, and doubts in plain sentences."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from warp_softbody.account import Shape
from warp_softbody.model import Model
from warp_softbody.step_statistics import StepStatistics

FloatArray = npt.NDArray[np.float64]

MOST_MISSING = 1e-3
"""Momentum that may be missing, of all that a body exchanged in a run."""

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
        body: name of the one that violates its contact laws most.
        node: its node, counted within that body; -1 where contact had settled and the linear solve
            had not reached its tolerance.
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


@dataclass
class RunAccount:
    """Sums and extremes of a run's steps and frames."""

    model: Model
    missing: FloatArray = field(init=False)
    exchanged: FloatArray = field(init=False)
    gained: FloatArray = field(init=False)
    energy: FloatArray = field(init=False)
    steps: int = 0
    bad_steps: int = 0
    worst: Unsettled | None = None
    most_inverted: int = 0
    inverted: int = 0
    volumes: FloatArray = field(init=False)
    least_volume: float = 1.0
    largest_volume: float = 1.0

    def __post_init__(self) -> None:
        """Begin with the momentum and energy of the scene's start."""
        model, scene = self.model, self.model.scene
        count = len(scene.parts)
        speeds = [scene.initial_velocity, *(body.velocity for body in scene.others)]
        masses = np.array([model.masses[part.nodes].sum() for part in scene.parts])
        speed = np.linalg.norm(np.asarray(speeds, dtype=float), axis=1)
        sizes = np.array([body_size(c.mesh.points) for c in scene.characters])
        self.missing = np.zeros((count, 3))
        self.exchanged = masses * speed
        self.gained = np.zeros(count)
        # of the fastest motion so far, and at least of a fall by a hundredth of the body
        fall = 0.01 * float(np.linalg.norm(scene.gravity)) * sizes
        self.energy = masses * np.maximum(0.5 * speed**2, fall)
        self.volumes = np.ones(count)
        self._sizes = sizes

    def note_step(self, statistics: StepStatistics, time: float) -> None:
        """Count a step that began at a time, s."""
        self.steps += 1
        account = statistics.account
        self.missing += account.missing
        self.exchanged += account.exchanged
        self.gained += account.gained
        if statistics.settled:
            return
        self.bad_steps += 1
        force = max(statistics.signorini, statistics.coulomb)
        if self.worst is None or force > self.worst.force:
            self.worst = self._named(statistics.worst_node, time, force)

    def _named(self, node: int, time: float, force: float) -> Unsettled:
        scene = self.model.scene
        for part in scene.parts:
            if part.nodes.start <= node < part.nodes.stop:
                own = node - part.nodes.start
                return Unsettled(time=time, body=part.name, node=own, force=force)
        return Unsettled(time=time, body=scene.parts[0].name, node=-1, force=force)

    def note_frame(self, shape: Shape, velocities: FloatArray) -> None:
        """Count a frame's shape, and its kinetic energy."""
        self.inverted = shape.inverted
        self.most_inverted = max(self.most_inverted, shape.inverted)
        self.volumes = shape.volumes
        self.least_volume = min(self.least_volume, float(shape.volumes.min()))
        self.largest_volume = max(self.largest_volume, float(shape.volumes.max()))
        squares = 0.5 * self.model.masses * np.einsum("ij,ij->i", velocities, velocities)
        starts = [part.nodes.start for part in self.model.scene.parts]
        self.energy = np.maximum(self.energy, np.add.reduceat(squares, starts))

    def findings(self, positions: FloatArray) -> Findings:
        """All of it, at the end of a run with nodes at ``positions`` (n, 3), m."""
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = np.linalg.norm(self.missing, axis=1) / self.exchanged
        momentum_error = float(np.nan_to_num(shares).max())
        depth, deepest = self._sunk(positions)
        return Findings(
            momentum_error=momentum_error,
            contact_gain=float(self.gained.sum()),
            inverted_tets=self.inverted,
            most_inverted=self.most_inverted,
            volumes=(self.least_volume, self.largest_volume),
            depth=depth,
            unsettled=self.worst,
            doubts=tuple(self._doubts(momentum_error, deepest)),
        )

    def _sunk(self, positions: FloatArray) -> tuple[float, float]:
        """Largest depth below the ground, m, and of the size of the body that it belongs to."""
        scene = self.model.scene
        if scene.ground is None or not np.isfinite(positions).all():
            return 0.0, 0.0
        surface = self.model.body.mesh.surface_nodes
        # a fixed node is where the scene wants it
        surface = surface[~self.model.fixed[surface]]
        gaps, _ = scene.ground.measure(positions[surface])
        depth, share = 0.0, 0.0
        for part, size in zip(scene.parts, self._sizes, strict=True):
            own = (surface >= part.nodes.start) & (surface < part.nodes.stop)
            least = max(0.0, -float(gaps[own].min(initial=0.0)))
            depth, share = max(depth, least), max(share, least / size)
        return depth, share

    def _doubts(self, momentum_error: float, sunk: float) -> list[str]:
        found = []
        if self.inverted:
            found.append(
                f"{self.inverted} of {self.model.tet_count} tets are inside out at the end: take a "
                "stiffer material, a finer mesh or a smaller time step"
            )
        swelling = float(np.abs(self.volumes - 1.0).max())
        if not swelling <= MOST_SWELLING:
            worst = self.model.scene.parts[int(np.abs(self.volumes - 1.0).argmax())].name
            found.append(
                f"body {worst!r} ends at {self.volumes[np.abs(self.volumes - 1.0).argmax()]:.3g} "
                "times its volume, where linear elasticity means little: take a stiffer material, "
                "a larger Poisson's ratio or a smaller time step"
            )
        if sunk > MOST_SUNK:
            found.append(
                f"a node ends {100.0 * sunk:.0f} % of its body's size below the ground: take a "
                "smaller time step or a finer surface"
            )
        if momentum_error > MOST_MISSING:
            found.append(
                f"{100.0 * momentum_error:.2g} % of the momentum that a body exchanged is "
                "unexplained: take precision float64 or a smaller tolerance"
            )
        gained = float((self.gained / np.maximum(self.energy, 1e-300)).max())
        if gained > MOST_GAINED:
            found.append(
                f"contact gave a body {100.0 * gained:.2g} % of its energy instead of taking it: "
                "take a smaller time step"
            )
        if self.bad_steps > max(1.0, MOST_UNSETTLED * self.steps):
            found.append(
                f"{self.bad_steps} of {self.steps} steps ended before they had settled: take a "
                "smaller time step, or more max_contact_passes"
            )
        return found


def body_size(points: FloatArray) -> float:
    """Diagonal of the box around points (n, 3), m."""
    return float(np.linalg.norm(np.ptp(points, axis=0)))
