"""Small bodies with known answers, and a rig that steps them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.muscles import Fiber, FiberKind, MuscleGroup
from warp_softbody.engine.model import Model, build_model
from warp_softbody.engine.options import Precision, SimulationOptions
from warp_softbody.engine.reduced_dynamics import ReducedDynamics
from warp_softbody.engine.state import SLACK, Contacts, Control, State
from warp_softbody.engine.step_statistics import StepStatistics
from warp_softbody.engine.stepper import Stepper
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

Vector = tuple[float, float, float]

EXACT: dict[str, Any] = {"precision": "float64", "tolerance": 1e-13}
"""Options with which every linear solve is as good as a direct one."""


def epsilon(precision: Precision) -> float:
    """Distance from 1 to the next number of a precision."""
    return float(np.finfo(np.dtype(precision)).eps)


def box(
    cells: tuple[int, int, int] = (2, 2, 2),
    size: Vector = (0.2, 0.2, 0.2),
    origin: Vector = (0.0, 0.0, 0.0),
    jitter: float = 0.0,
) -> TetMesh:
    """A grid of cells of six Kuhn tets; inner nodes move by up to ``jitter`` of a cell."""
    ticks = [np.linspace(0.0, s, c + 1) for s, c in zip(size, cells, strict=True)]
    points = np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, 3)
    shape = tuple(c + 1 for c in cells)
    corner = np.stack(np.meshgrid(*map(np.arange, cells), indexing="ij"), axis=-1).reshape(-1, 3)
    tets = []
    for path in itertools.permutations(range(3)):
        steps = np.zeros((4, 3), dtype=int)
        for count, axis in enumerate(path):
            steps[count + 1 :, axis] += 1
        index = corner[:, None, :] + steps
        tets.append(np.ravel_multi_index(tuple(np.moveaxis(index, -1, 0)), shape))
    if jitter > 0.0:
        inner = ((points > 1e-12) & (points < np.asarray(size) - 1e-12)).all(axis=1)
        cell = np.asarray(size) / np.asarray(cells)
        move = np.random.default_rng(5).uniform(-jitter, jitter, points.shape) * cell
        points[inner] += move[inner]
    return TetMesh.from_arrays(points + np.asarray(origin), np.concatenate(tets))


def straight_fiber(name: str, start: Sequence[float], end: Sequence[float], count: int) -> Fiber:
    """A straight fibre of ``count`` equal segments."""
    return Fiber(
        vertices=np.linspace(start, end, count + 1), kind=FiberKind.LONGITUDINAL, name=name
    )


def muscular_bar(
    material: Material | None = None,
    origin: Vector = (0.0, 0.0, 0.0),
    strength: float = 2e5,
    helix: bool = False,
) -> Character:
    """An upright bar of 0.2 x 0.2 x 0.6 m, 144 tets, with two fibres of six segments along z.

    With ``helix``, a second, weaker group of one fibre that winds around them in eight segments.
    """
    mesh = box((2, 2, 6), (0.2, 0.2, 0.6), origin)
    x, y, z = origin

    def fiber(name: str, dx: float) -> Fiber:
        return straight_fiber(
            name, (x + dx, y + 0.1, z + 0.01), (x + dx, y + 0.1, z + 0.59), count=6
        )

    group = MuscleGroup(
        fibers=(fiber("left", 0.04), fiber("right", 0.16)),
        strength=strength,
        kernel_width=0.08,
        name="both",
    )
    groups: tuple[MuscleGroup, ...] = (group,)
    if helix:
        angle = np.linspace(0.0, 2.0 * np.pi, 9)
        wound = np.stack([0.1 + 0.07 * np.cos(angle), 0.1 + 0.07 * np.sin(angle)], axis=1)
        rising = np.column_stack([wound, np.linspace(0.05, 0.55, 9)]) + np.asarray(origin)
        winding = Fiber(vertices=rising, kind=FiberKind.HELICAL, name="helix")
        groups += (
            MuscleGroup(
                fibers=(winding,), strength=0.5 * strength, kernel_width=0.1, name="around"
            ),
        )
    height = mesh.points[:, 2] - z
    regions = {
        "base": np.flatnonzero(height < 1e-9).astype(np.int32),
        "top": np.flatnonzero(height > 0.6 - 1e-9).astype(np.int32),
    }
    return Character(
        name="bar",
        mesh=mesh,
        material=material or Material(young_modulus=2e5, poisson_ratio=0.4, stiffness_damping=0.01),
        muscles=groups,
        regions=regions,
    )


@dataclass
class Rig:
    """A model, its state and all that a step needs; steps swap the two states."""

    model: Model
    stepper: Stepper
    state: State
    after: State
    control: Control
    contacts: Contacts
    statistics: StepStatistics | None = None

    @property
    def positions(self) -> FloatArray:
        """(n, 3) m."""
        return numbers(self.state.positions)

    @property
    def velocities(self) -> FloatArray:
        """(n, 3) m/s."""
        return numbers(self.state.velocities)

    @property
    def masses(self) -> FloatArray:
        """(n,) kg."""
        return self.model.masses

    @property
    def momentum(self) -> FloatArray:
        """(3,) kg m/s."""
        return np.asarray(self.masses @ self.velocities)

    @property
    def angular_momentum(self) -> FloatArray:
        """About the centre of mass, (3,) kg m^2/s."""
        arms = self.positions - self.center
        return np.asarray(self.masses @ np.cross(arms, self.velocities))

    @property
    def center(self) -> FloatArray:
        """Centre of mass, (3,) m."""
        return np.asarray(self.masses @ self.positions / self.masses.sum())

    def place(self, positions: FloatArray | None = None, velocities: Any = None) -> None:
        """Overwrite positions (n, 3) or velocities (n, 3) or (3,)."""
        if positions is not None:
            self.state.positions.assign(positions)
        if velocities is not None:
            spread = np.broadcast_to(np.asarray(velocities, dtype=float), self.positions.shape)
            self.state.velocities.assign(np.ascontiguousarray(spread))

    def activate(self, activations: npt.ArrayLike | None) -> FloatArray:
        """Set l_d / l_0 of all segments (None for slack); the rest lengths in m."""
        rest = self.model.muscles.rest_lengths
        share = np.asarray(SLACK if activations is None else activations, dtype=float)
        lengths = np.ascontiguousarray(np.broadcast_to(share * rest, rest.shape))
        self.control.rest_lengths.assign(lengths)
        return lengths

    def push(self, forces: FloatArray) -> None:
        """External forces (n, 3) N from now on."""
        self.control.external_forces.assign(forces)

    def step(self, count: int = 1) -> StepStatistics:
        """Advance by some steps; the statistics of the last one."""
        for _ in range(count):
            self.statistics = self.stepper.step(self.state, self.control, self.contacts, self.after)
            self.state, self.after = self.after, self.state
        assert self.statistics is not None
        return self.statistics


def numbers(array: Any) -> FloatArray:
    """A copy of a device array as float64; what Warp hands out is a window on the array."""
    return np.array(array.numpy(), dtype=np.float64)


PLAIN = {"elements": "linear", "tangent": "warped", "muscles": "explicit"}
"""Options of a rig."""


def rig(
    body: TetMesh | Character,
    *,
    material: Material | None = None,
    fixed: npt.ArrayLike = (),
    ground: Plane | None = None,
    gravity: Vector = (0.0, 0.0, 0.0),
    **options: Any,
) -> Rig:
    """A rig of a mesh or a character, in free space without gravity unless told otherwise.

    Elements, tangent and muscles are the plain ones, whose kernels tests launch by themselves.
    """
    if isinstance(body, TetMesh):
        indices = np.asarray(fixed, dtype=np.int32)
        body = Character(name="body", mesh=body, material=material or Material(), fixed=indices)
    scene = Scene(character=body, ground=ground, gravity=gravity)
    model = build_model(scene, SimulationOptions(**{**PLAIN, **options}))
    return Rig(
        model=model,
        stepper=Stepper(model),
        state=State.at_rest(model),
        after=State.at_rest(model),
        control=Control.slack(model),
        contacts=Contacts.none(model),
    )


def exact_dynamics(body: Rig, row_capacity: int = 16) -> ReducedDynamics:
    """Reduced dynamics as exact as double precision allows."""
    return ReducedDynamics(body.stepper, row_capacity, tolerance=1e-13)


def given_back(
    masses: FloatArray, positions: FloatArray, velocities: FloatArray, known: FloatArray
) -> FloatArray:
    """Velocities (n, 3) with the turn that leaves a free body the moment of its known momentum.

    Args:
        masses: damped ones, (n,) kg.
        positions: at the start of the step, (n, 3) m.
        velocities: v+ of the step's matrix alone, (n, 3) m/s.
        known: M v + dt f, (n, 3) kg m/s, where inner forces may stand, as they have no moment.
    """
    arms = positions - masses @ positions / masses.sum()
    lacks = np.cross(arms, known - masses[:, None] * velocities).sum(axis=0)
    squares = np.einsum("n,na,nb->ab", masses, arms, arms)
    inertia = np.trace(squares) * np.eye(3) - squares
    return np.asarray(velocities + np.cross(np.linalg.solve(inertia, lacks), arms))


def turned(points: FloatArray, axis: Sequence[float], angle: float) -> FloatArray:
    """Points turned about an axis through the origin by an angle in radians."""
    return np.asarray(points @ turn(axis, angle).T)


def turn(axis: Sequence[float], angle: float) -> FloatArray:
    """Rotation matrix (Rodrigues)."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)
    return np.asarray(rotation)


def crumpled(mesh: TetMesh, amount: float = 0.15, seed: int = 3) -> FloatArray:
    """Points of a mesh turned, sheared and shaken by ``amount`` of the shortest edge."""
    rng = np.random.default_rng(seed)
    edges = mesh.points[mesh.tets[:, 1:]] - mesh.points[mesh.tets[:, :1]]
    shortest = np.linalg.norm(edges, axis=2).min()
    shear = np.eye(3) + 0.2 * rng.uniform(-1.0, 1.0, (3, 3))
    shaken = mesh.points @ shear.T + amount * shortest * rng.uniform(-1.0, 1.0, mesh.points.shape)
    return np.asarray(turned(shaken, (1.0, 2.0, -0.5), 2.0) + np.array([0.3, -0.2, 0.1]))
