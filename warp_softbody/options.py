"""How a scene is simulated: numbers that change cost and accuracy, never what the scene means."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

from warp_softbody.errors import InputError

Precision = Literal["auto", "float32", "float64"]
Tangent = Literal["warped", "conserving", "exact"]
Elements = Literal["linear", "smoothed"]
Cone = Literal["smooth", "4", "8"]
TANGENTS: tuple[Tangent, ...] = get_args(Tangent)
ELEMENTS: tuple[Elements, ...] = get_args(Elements)
CONES: tuple[Cone, ...] = get_args(Cone)
PRECISIONS: tuple[Precision, ...] = get_args(Precision)


@dataclass(frozen=True, kw_only=True)
class SimulationOptions:
    """Settings of the stepper, validated on construction.

    Attributes:
        time_step: dt, s.
        precision: floating-point type of the state and of every solve; "auto" takes float32 where
            its rounding is small beside what a step changes, and float64 elsewhere
            (`precision_choice`). A model's options say which.
        tangent: the stiffness matrix of the implicit step and of stiffness damping. "warped" is the
            paper's, rest stiffness turned with each tet, and costs least. "conserving" includes the
            change of the rotations, so that a free body keeps its angular momentum to rounding.
            "exact" is the derivative of the elastic force, made positive semidefinite.
        elements: "linear" four-node tets, or "smoothed" ones, which hardly lock in bending and near
            incompressibility; they take their forces from strains averaged over edges and nodes,
            and go with the warped tangent alone.
        cone: of friction, "smooth", or a polygon of "4" or "8" directions evenly spread from the
            contact's first tangent, which lies along x where possible. On a polygon a sliding node
            takes the friction that dissipates most, a corner unless it moves across an edge.
        newton_iterations: of one step; 1 is the linearly implicit step, more come nearer to the
            implicit Euler step, each for the price of a step.
        device: a Warp device name, "cpu" or "cuda:0".
        threads: that assemble forces and matrix side by side, on the CPU; worth while from some
            ten thousand tets. Results do not depend on it.
        tolerance: relative residual |b - M~ v| / |b| at which the linear solve stops, fixed nodes
            not counted. None stops it where it adds a twentieth to the error of the time step, or
            at 1e-5 in float32 and 1e-6 in float64; in controlled scenes always at these.
        max_iterations: of conjugate gradients in one pass; a solve that needs more is counted as
            not converged.
        max_contact_passes: active-set passes of one step in which contact modes are sought; where
            they have not settled then, up to twenty more only let nodes go (docs/contact.md).
        bridge_tolerance: relative residual of the controller's block solve.
        recovery_speed: largest speed, m/s, at which a sunken node is pushed out; None for 0.5 m/s,
            less in proportion for bodies smaller than a metre (`Model.speed_share`).
        sleep: whether steps are left out while all bodies are at rest and nothing acts on them.
    """

    time_step: float = 1.0 / 120.0
    precision: Precision = "auto"
    tangent: Tangent = "warped"
    elements: Elements = "linear"
    cone: Cone = "smooth"
    newton_iterations: int = 1
    device: str = "cpu"
    threads: int = 1
    tolerance: float | None = None
    max_iterations: int = 400
    max_contact_passes: int = 50
    bridge_tolerance: float = 1e-3
    recovery_speed: float | None = None
    sleep: bool = True

    def __post_init__(self) -> None:
        """Refuse what cannot be simulated."""
        if not (math.isfinite(self.time_step) and self.time_step > 0.0):
            raise InputError(
                f"time_step must be a positive number of seconds, got {self.time_step!r}"
            )
        known_values = {
            "precision": PRECISIONS,
            "tangent": TANGENTS,
            "elements": ELEMENTS,
            "cone": CONES,
        }
        for name, known in known_values.items():
            value = getattr(self, name)
            if value not in known:
                raise InputError(f"{name} must be one of {', '.join(known)}, got {value!r}")
        if self.elements == "smoothed" and self.tangent != "warped":
            raise InputError(
                f"smoothed elements have a warped tangent only, got tangent {self.tangent!r}"
            )
        for name in ("tolerance", "bridge_tolerance", "recovery_speed"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise InputError(f"{name} must be a positive number, got {value!r}")
        for name in ("max_iterations", "max_contact_passes", "newton_iterations", "threads"):
            value = getattr(self, name)
            if value < 1:
                raise InputError(f"{name} must be at least 1, got {value!r}")

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
