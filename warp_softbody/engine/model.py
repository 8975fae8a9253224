"""The constant part of a simulation, on the device."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.device.allocator import Allocator, DeviceArray
from warp_softbody.device.kernel_loading import prepare
from warp_softbody.device.turns import shares_warp
from warp_softbody.device.warp_runtime import check_device
from warp_softbody.engine.contact_tolerances import speed_share
from warp_softbody.engine.first_kernels import first_kernels
from warp_softbody.engine.linear_system import build_levels, build_linear_system
from warp_softbody.engine.material_parts import MaterialPart, material_parts
from warp_softbody.engine.model_arrays import ModelArrays
from warp_softbody.engine.model_sharing import (
    same_arrays,
    same_meshes,
    shared_layout,
    shared_levels,
)
from warp_softbody.engine.muscle_layout import MuscleLayout, build_muscle_layout, join_layouts
from warp_softbody.engine.option_choice import with_choices
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.kernels.precision import Real, real
from warp_softbody.linear.block_sparsity import Topology, build_topology
from warp_softbody.linear.system import LinearSystem
from warp_softbody.world.scene import Scene

RECOVERY_SPEED = 0.5
"""Speed, m/s, at which a sunken node of a body of a metre is pushed out."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Model:
    """What stays constant, on host and device.

    Attributes:
        scene: what is simulated.
        options: how, with what each "auto" takes.
        topology: index arrays of the joined mesh, on the host.
        fixed: (n,) bool, nodes that never move, or as handles move them that never let go.
        muscles: the segments of all bodies, on the host.
        masses: (n,) kg, float64 on the host.
        materials: of each body.
        arrays: everything constant that kernels read, on the device.
        system: the constant part of the step's linear systems.
    """

    scene: Scene
    options: SimulationOptions
    topology: Topology
    fixed: npt.NDArray[np.bool_]
    muscles: MuscleLayout
    masses: FloatArray
    materials: tuple[MaterialPart, ...]
    arrays: ModelArrays
    system: LinearSystem

    @property
    def body(self) -> Character:
        """All bodies of the scene as one of several parts."""
        return self.scene.whole

    @property
    def node_count(self) -> int:
        """Number of nodes."""
        return len(self.masses)

    @property
    def tet_count(self) -> int:
        """Number of tets."""
        return len(self.body.mesh.tets)

    @property
    def segment_count(self) -> int:
        """Number of muscle segments."""
        return len(self.muscles.rest_lengths)

    @property
    def contact_count(self) -> int:
        """Number of nodes that can touch the ground; 0 without a ground."""
        return 0 if self.scene.ground is None else len(self.body.mesh.surface_nodes)

    @property
    def handled_count(self) -> int:
        """Number of nodes where velocities of handles are kept: all, or 0 without handles."""
        return self.node_count if self.scene.handles else 0

    @property
    def held_count(self) -> int:
        """Number of nodes of which is kept whether they are held: all, or 0 if none is let go."""
        return self.node_count if len(self.scene.let_go) else 0

    @property
    def has_pairs(self) -> bool:
        """Whether there are contacts of several nodes: with surfaces, or with edges of a ground."""
        return self.scene.has_pairs or self.scene.has_ground_edges

    @property
    def absent_parts(self) -> tuple[str, ...]:
        """Which of "muscles" and "contact" the scene has none of."""
        touchable = self.scene.ground is not None or self.scene.has_pairs
        there = {"muscles": self.segment_count > 0, "contact": touchable}
        return tuple(part for part, is_there in there.items() if not is_there)

    @property
    def speed_share(self) -> float:
        """What speeds count for small bodies, of those that do for a metre on Earth; at most 1."""
        return speed_share(self.scene)

    @property
    def recovery_speed(self) -> float:
        """Largest speed at which a sunken node is pushed out, m/s."""
        asked = self.options.recovery_speed
        return RECOVERY_SPEED * self.speed_share if asked is None else asked

    @property
    def types(self) -> Real:
        """Warp types of the precision."""
        return self.allocator.types

    @property
    def allocator(self) -> Allocator:
        """Makes device arrays."""
        return self.system.allocator

    def array(self, values: npt.ArrayLike, dtype: Any) -> DeviceArray:
        """A device array of values."""
        return self.allocator.array(values, dtype)

    def zeros(self, shape: int | tuple[int, ...], dtype: Any) -> DeviceArray:
        """A device array of zeros."""
        return self.allocator.zeros(shape, dtype)


@shares_warp
def build_model(scene: Scene, options: SimulationOptions, *, like: Model | None = None) -> Model:
    """The model of a scene: index arrays, rest shape, masses, muscle weights, ground.

    Args:
        scene: what is simulated.
        options: how.
        like: a model whose constant arrays this one shares as far as they are the same, so that
            copies of a scene with other pushes or materials cost little; the results are the same.

    Raises:
        InputError: options that do not go with the scene, or a device that is not there.
    """
    checks.instance("scene of build_model", scene, Scene)
    checks.instance("options of build_model", options, SimulationOptions)
    if like is not None:
        checks.instance("like of build_model", like, Model)
    # made anew, so that one that went round its constructor is checked too
    options = replace(options)
    check_device(options.device)
    options = with_choices(options, scene)
    if options.native_code and options.device == "cpu":
        prepare(options.device, first_kernels(options.precision))
    _refuse_mixtures(scene, options)
    if like is not None and not same_meshes(scene, like.scene):
        like = None
    mesh, parts = scene.whole.mesh, scene.parts
    topology = build_topology(mesh.tets, len(mesh.points)) if like is None else like.topology
    fixed = np.zeros(len(mesh.points), dtype=bool)
    fixed[scene.held] = True
    fixed[scene.let_go] = False
    levels = None
    if like is not None:
        levels = shared_levels(like.system, options, like.options, fixed, like.fixed)
    levels = levels or build_levels(scene, topology, fixed, options.preconditioner)
    make = Allocator(real(options.precision), options.device)
    muscles = _muscles(scene, like)
    masses = np.concatenate([character.node_masses for character in scene.characters])
    dt = options.time_step
    materials = material_parts(parts, topology, dt, make)
    shared = like.arrays if like is not None and same_arrays(options, like.options) else None
    same_fibers = like is not None and muscles.pair_tet is like.muscles.pair_tet
    arrays = ModelArrays.of(
        *(scene, topology, muscles, masses, materials, dt, make),
        like=shared,
        fibers=shared.muscles if shared is not None and same_fibers else None,
    )
    return Model(
        scene=scene,
        options=options,
        topology=topology,
        fixed=fixed,
        muscles=muscles,
        masses=masses,
        materials=materials,
        arrays=arrays,
        system=build_linear_system(
            scene, options, topology, levels, masses, materials, arrays, make
        ),
    )


def _muscles(scene: Scene, like: Model | None) -> MuscleLayout:
    """The segments of all bodies, those of a model of the same meshes where they are the same."""
    found = None
    if like is not None:
        found = shared_layout(like.muscles, scene, like.scene.characters)
    if found is not None:
        return found
    layouts = [build_muscle_layout(character) for character in scene.characters]
    return join_layouts(layouts, scene.parts)


def _refuse_mixtures(scene: Scene, options: SimulationOptions) -> None:
    for character in scene.characters:
        if character.materials and character.muscles and options.muscles == "explicit":
            raise InputError(
                f"body {character.name!r} has materials by region, which go with implicit muscles, "
                "got muscles 'explicit'"
            )
    if options.elements == "linear" or options.tangent == "warped":
        return
    for character in scene.characters:
        if character.material.volume != "exact":
            raise InputError(
                f"body {character.name!r} resists the trace of its strain, for which smoothed "
                f"elements have a warped tangent only, got tangent {options.tangent!r}"
            )
