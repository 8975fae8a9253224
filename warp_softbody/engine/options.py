"""How a scene is simulated: numbers that change cost and accuracy, never what the scene means."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Literal, get_args

from warp_softbody.errors import InputError
from warp_softbody.inputs import checks

Precision = Literal["auto", "float32", "float64"]
Tangent = Literal["warped", "conserving", "exact"]
Elements = Literal["linear", "smoothed"]
Cone = Literal["smooth", "4", "8"]
PRECISIONS: tuple[Precision, ...] = get_args(Precision)
TANGENTS: tuple[Tangent, ...] = get_args(Tangent)
ELEMENTS: tuple[Elements, ...] = get_args(Elements)
CONES: tuple[Cone, ...] = get_args(Cone)
DEVICE = re.compile(r"cpu|cuda(:\d+)?")

SHORTEST_STEP, LONGEST_STEP = 1e-9, 1e4
"""s, the range of time steps that are taken for what was meant; a step of 1000 s finds where a held
body comes to rest."""


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
    max_contact_passes: int = 80
    bridge_tolerance: float = 1e-3
    recovery_speed: float | None = None
    sleep: bool = True

    def __post_init__(self) -> None:
        """Refuse what cannot be simulated."""
        self._check_choices()
        self._keep("time_step", low=SHORTEST_STEP, high=LONGEST_STEP, unit="s")
        self._keep("bridge_tolerance", above=0.0, below=1.0)
        if self.recovery_speed is not None:
            self._keep("recovery_speed", above=0.0, unit="m/s")
        if self.tolerance is not None:
            self._keep("tolerance", above=0.0, below=1.0)
        for name in ("max_iterations", "max_contact_passes", "newton_iterations"):
            count = checks.whole(f"SimulationOptions.{name}", getattr(self, name), low=1)
            checks.keep(self, **{name: count})
        checks.keep(
            self,
            threads=checks.whole("SimulationOptions.threads", self.threads, low=1, high=1024),
            sleep=checks.truth("SimulationOptions.sleep", self.sleep),
        )

    def _check_choices(self) -> None:
        for name, known in (
            ("precision", PRECISIONS),
            ("tangent", TANGENTS),
            ("elements", ELEMENTS),
            ("cone", CONES),
        ):
            value = checks.choice(f"SimulationOptions.{name}", getattr(self, name), known)
            checks.keep(self, **{name: value})
        if self.elements == "smoothed" and self.tangent != "warped":
            raise InputError(
                f"smoothed elements have a warped tangent only, got tangent {self.tangent!r}"
            )
        if not (isinstance(self.device, str) and DEVICE.fullmatch(self.device)):
            checks.refuse("SimulationOptions.device", '"cpu", "cuda" or "cuda:0"', self.device)

    def _keep(self, name: str, **limits: Any) -> None:
        value = checks.number(f"SimulationOptions.{name}", getattr(self, name), **limits)
        checks.keep(self, **{name: value})

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
