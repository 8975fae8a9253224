"""How a scene is simulated: numbers that change cost and accuracy, never what the scene means."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Literal, get_args

from warp_softbody.errors import InputError
from warp_softbody.inputs.option_fields import check_options, described, option
from warp_softbody.inputs.option_kinds import (
    ChoiceKind,
    NumberKind,
    TextKind,
    TruthKind,
    WholeKind,
)

Precision = Literal["auto", "float32", "float64"]
NamedTangent = Literal["warped", "conserving", "exact"]
Tangent = Literal["auto", NamedTangent]
NamedElements = Literal["linear", "smoothed"]
Elements = Literal["auto", NamedElements]
MuscleLaw = Literal["explicit", "implicit"]
Cone = Literal["smooth", "4", "8"]
PreconditionerChoice = Literal["auto", "factor", "two_level"]
PRECISIONS: tuple[Precision, ...] = get_args(Precision)
TANGENTS: tuple[NamedTangent, ...] = get_args(NamedTangent)
ELEMENTS: tuple[NamedElements, ...] = get_args(NamedElements)
MUSCLE_LAWS: tuple[MuscleLaw, ...] = get_args(MuscleLaw)
CONES: tuple[Cone, ...] = get_args(Cone)
PRECONDITIONERS: tuple[PreconditionerChoice, ...] = get_args(PreconditionerChoice)
DEVICE = re.compile(r"cpu|cuda(:\d+)?")

SHORTEST_STEP, LONGEST_STEP = 1e-9, 1e4
"""s, the range of time steps that are taken for what was meant; a step of 1000 s finds where a held
body comes to rest."""


@described
@dataclass(frozen=True, kw_only=True)
class SimulationOptions:
    """Settings of the stepper, validated on construction; each field describes itself."""

    time_step: float = field(
        default=1.0 / 120.0,
        metadata=option(
            NumberKind(low=SHORTEST_STEP, high=LONGEST_STEP, unit="s"),
            "longest time step; a run shortens it to a whole number of steps in a frame",
            knob="time_step",
            short="dt",
        ),
    )
    precision: Precision = field(
        default="auto",
        metadata=option(
            ChoiceKind(PRECISIONS),
            "floating-point type of the state and of every solve; auto takes float32 where its "
            "rounding is small beside what a step changes, and float64 elsewhere",
            knob="precision",
            short="",
        ),
    )
    tangent: Tangent = field(
        default="auto",
        metadata=option(
            ChoiceKind(("auto", *TANGENTS)),
            "stiffness matrix of the implicit step and of stiffness damping: rest stiffness "
            "turned with each tet, which costs least; conserving includes the change of the "
            "rotations, so that a free body keeps its angular momentum to rounding; exact is the "
            "derivative of the elastic force, made positive semidefinite; auto takes "
            "conserving for bodies with muscles, where the elements have it, and warped elsewhere",
            knob="tangent",
        ),
    )
    elements: Elements = field(
        default="auto",
        metadata=option(
            ChoiceKind(("auto", *ELEMENTS)),
            "four-node tets; smoothed ones take their forces from strains averaged over edges and "
            "nodes, which relieves locking in bending and near incompressibility, and go with the "
            "warped tangent, where volumes are exact with the conserving one too; auto takes them "
            "for bodies with muscles",
            knob="elements",
            short="",
        ),
    )
    muscles: MuscleLaw = field(
        default="implicit",
        metadata=option(
            ChoiceKind(MUSCLE_LAWS),
            "tension of muscles: explicit, from the length at the step's start; implicit ones have "
            "an energy, whose stiffness the matrix of the step and of its plan knows",
        ),
    )
    cone: Cone = field(
        default="smooth",
        metadata=option(
            ChoiceKind(CONES),
            "friction cone, smooth or a polygon of so many directions, evenly spread from the "
            "contact's first tangent, which lies along x where possible; on a polygon a sliding "
            "node takes the friction that dissipates most",
            knob="cone",
        ),
    )
    newton_iterations: int = field(
        default=1,
        metadata=option(
            WholeKind(low=1),
            "Newton iterations of a step; 1 is the linearly implicit step, more approach the "
            "implicit Euler step, each for the price of a step, and are halved where they would "
            "lead away from it",
            knob="newton_iterations",
            short="Newton",
        ),
    )
    device: str = field(
        default="cpu",
        metadata=option(
            TextKind(pattern=DEVICE, wanted='"cpu", "cuda" or "cuda:0"'),
            "name of a Warp device",
            moves=False,
        ),
    )
    threads: int = field(
        default=1,
        metadata=option(
            WholeKind(low=1, high=1024),
            "threads that assemble forces and matrix side by side, on the CPU; worth while from "
            "some ten thousand tets",
            moves=False,
            knob="threads",
        ),
    )
    tolerance: float | None = field(
        default=None,
        metadata=option(
            NumberKind(above=0.0, below=1.0),
            "residual of the linear solve, relative to its right-hand side, at which it stops; "
            "fixed nodes are not counted",
            unset="where it adds a twentieth to the error of the time step, or at 1e-5 in float32 "
            "and 1e-6 in float64; in controlled scenes always at these",
            knob="tolerance",
        ),
    )
    max_iterations: int = field(
        default=400,
        metadata=option(
            WholeKind(low=1),
            "conjugate gradient iterations of one contact pass; a solve that needs more is "
            "counted as not converged",
        ),
    )
    max_contact_passes: int = field(
        default=80,
        metadata=option(
            WholeKind(low=1),
            "active-set passes of one step in which contact modes are sought; where they have not "
            "settled then, up to twenty more only let nodes go",
        ),
    )
    preconditioner: PreconditionerChoice = field(
        default="auto",
        metadata=option(
            ChoiceKind(PRECONDITIONERS),
            "of conjugate gradients: a sparse factor of an earlier step's matrix, or two levels "
            "(docs/preconditioners.md); auto takes the one that costs less at the body's size",
            knob="preconditioner",
            short="",
        ),
    )
    recovery_speed: float | None = field(
        default=None,
        metadata=option(
            NumberKind(above=0.0, unit="m/s"),
            "largest speed at which a sunken node is pushed out",
            unset="0.5 m/s, less in proportion for bodies smaller than a metre "
            "(`Model.speed_share`)",
        ),
    )
    sleep: bool = field(
        default=True,
        metadata=option(
            TruthKind(),
            "whether steps are left out while all bodies are at rest and nothing acts on them",
        ),
    )
    native_code: bool = field(
        default=True,
        metadata=option(
            TruthKind(),
            "whether kernels use native code for processors where there is some; the plain Warp "
            "kernels, which other devices take, do the same to rounding",
            moves=False,
        ),
    )

    def __post_init__(self) -> None:
        """Refuse what cannot be simulated."""
        check_options(self)
        if self.elements == "smoothed" and self.tangent == "exact":
            raise InputError("smoothed elements have no exact tangent, got tangent 'exact'")

    @property
    def cone_directions(self) -> int:
        """Corners of the friction cone's polygon; 0 for the smooth cone."""
        return 0 if self.cone == "smooth" else int(self.cone)

    @property
    def follows_time_error(self) -> bool:
        """Whether the linear solve is only as good as the time step deserves."""
        return self.tolerance is None

    @property
    def solver_tolerance(self) -> float:
        """The linear solve's least relative residual, with the precision's own filled in."""
        if self.tolerance is not None:
            return self.tolerance
        return 1e-6 if self.precision == "float64" else 1e-5
