"""Names of schemas and attributes by which other programs know a deformable body.

Those of proposal 111 to OpenUSD ("deformable body physics"), as the `physics:` namespace of Newton
1.8 reads them, and those of NVIDIA's Omniverse, from which it came. A change of names is a change
of this file.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

Profile = Literal["newton", "omni", "none"]
PROFILES: tuple[Profile, ...] = get_args(Profile)


@dataclass(frozen=True, kw_only=True)
class PhysicsNames:
    """What the parts of a deformable body are called.

    Attributes:
        body: schema of the prim that holds all of a body.
        simulation: schema of its tets.
        material: schema of its material.
        space: namespace of the attributes.
    """

    body: str
    simulation: str
    material: str
    space: str

    def attribute(self, name: str) -> str:
        """An attribute with its namespace."""
        return f"{self.space}:{name}"


NAMES = {
    "newton": PhysicsNames(
        body="PhysicsDeformableBodyAPI",
        simulation="PhysicsVolumeDeformableSimAPI",
        material="PhysicsVolumeDeformableMaterialAPI",
        space="physics",
    ),
    "omni": PhysicsNames(
        body="OmniPhysicsDeformableBodyAPI",
        simulation="OmniPhysicsVolumeDeformableSimAPI",
        material="OmniPhysicsDeformableMaterialAPI",
        space="omniphysics",
    ),
}
