"""A `Material` has the elastic constants, the density and the Rayleigh damping of a body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

from warp_softbody.inputs import checks

Volume = Literal["linear", "exact"]
VOLUMES: tuple[Volume, ...] = get_args(Volume)


@dataclass(frozen=True, kw_only=True)
class Material:
    """An isotropic material, linear in the corotated strain (docs/method.md section 1).

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
        for name, unit in (("young_modulus", "Pa"), ("density", "kg/m^3")):
            self._keep(name, above=0.0, unit=unit)
        for name, unit in (("stiffness_damping", "s"), ("mass_damping", "1/s")):
            self._keep(name, low=0.0, unit=unit)
        self._keep("poisson_ratio", above=-1.0, below=0.5)
        checks.keep(self, volume=checks.choice("Material.volume", self.volume, VOLUMES))

    def _keep(self, name: str, **limits: Any) -> None:
        value = checks.number(f"Material.{name}", getattr(self, name), **limits)
        checks.keep(self, **{name: value})

    @property
    def lame_mu(self) -> float:
        """Shear modulus mu, Pa."""
        return self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def lame_lambda(self) -> float:
        """First Lame parameter lambda, Pa."""
        nu = self.poisson_ratio
        return self.young_modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
