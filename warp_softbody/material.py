"""Elastic material with Rayleigh damping."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

from warp_softbody.errors import InputError

Volume = Literal["linear", "exact"]
VOLUMES: tuple[Volume, ...] = get_args(Volume)


@dataclass(frozen=True, kw_only=True)
class Material:
    """Isotropic, linear in the corotated strain (docs/method.md section 1).

    Attributes:
        young_modulus: E, Pa, > 0.
        poisson_ratio: nu, in (-1, 0.5).
        density: rho, kg/m^3, > 0.
        stiffness_damping: Rayleigh lambda, s, >= 0: damping force -lambda K v.
        mass_damping: Rayleigh mu, 1/s, >= 0: damping force -mu M v.
        volume: what lambda resists: with "linear" the trace of the strain, as corotational linear
            elasticity has it; with "exact" the change of volume, which differs from it where
            strains are large.
    """

    young_modulus: float = 5e5
    poisson_ratio: float = 0.45
    density: float = 1000.0
    stiffness_damping: float = 0.05
    mass_damping: float = 0.0
    volume: Volume = "linear"

    def __post_init__(self) -> None:
        """Refuse values outside the physical range."""
        for name, low in (
            ("young_modulus", 0.0),
            ("density", 0.0),
        ):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > low):
                raise InputError(f"material {name} must be finite and above {low:g}, got {value!r}")
        for name in ("stiffness_damping", "mass_damping"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError(f"material {name} must be finite and not negative, got {value!r}")
        if self.volume not in VOLUMES:
            raise InputError(
                f"material volume must be one of {', '.join(VOLUMES)}, got {self.volume!r}"
            )
        if not -1.0 < self.poisson_ratio < 0.5:
            raise InputError(
                f"material poisson_ratio must lie in (-1, 0.5), got {self.poisson_ratio!r}"
            )

    @property
    def lame_mu(self) -> float:
        """Shear modulus mu, Pa."""
        return self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def lame_lambda(self) -> float:
        """First Lame parameter lambda, Pa."""
        nu = self.poisson_ratio
        return self.young_modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
