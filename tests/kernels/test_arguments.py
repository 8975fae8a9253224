"""Kernels group their arguments, and launches hand over what kernels declare."""

import ast
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warp as wp

from tests.support.bodies import box, muscular_bar, rig
from warp_softbody.body.material import Material
from warp_softbody.device.launching import argument_groups, launch, launched_kernels
from warp_softbody.engine.body_sums import BodySums
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.engine.reduced_dynamics import ReducedDynamics
from warp_softbody.environment.senses import Senses
from warp_softbody.kernels.muscles import make_muscles
from warp_softbody.run.simulation import Simulation
from warp_softbody.scenes import make
from warp_softbody.world.friction_map import FrictionMap
from warp_softbody.world.ground import Plane
from warp_softbody.world.handles import Handle
from warp_softbody.world.height_field import HeightField
from warp_softbody.world.motion_path import MotionPath

ROOT = Path(__file__).parents[2]
MOST_ARGUMENTS = 12


def kernels() -> Iterator[tuple[str, ast.FunctionDef, str]]:
    """Key, syntax tree and source of every kernel of the package."""
    for path in sorted((ROOT / "kernels").rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        for factory in ast.parse(text).body:
            for node in ast.walk(factory):
                if isinstance(node, ast.FunctionDef) and any(
                    isinstance(mark, ast.Name) and mark.id == "kernel"
                    for mark in node.decorator_list
                ):
                    assert isinstance(factory, ast.FunctionDef)
                    source = ast.get_source_segment(text, node)
                    assert source is not None
                    yield f"{factory.name}__locals__{node.name}", node, source


def test_arguments_stand_in_groups() -> None:
    for _, node, source in kernels():
        assert sum(map(len, argument_groups(source).values())) == len(node.args.args)


def test_long_lists_of_arguments_are_structs() -> None:
    longer = [node.name for _, node, _ in kernels() if len(node.args.args) > MOST_ARGUMENTS]
    assert longer == []


def test_every_launch_is_compared_with_its_kernel() -> None:
    for path in sorted((ROOT / "warp_softbody").rglob("*.py")):
        if path.name != "launching.py":
            assert "wp.launch(" not in path.read_text(encoding="utf-8"), path


def test_every_kernel_s_launch_hands_over_what_it_declares() -> None:
    """Kernels of grounds, pairs, control, tangents, elements and preconditioners, all launched."""
    for name in ("balance-i", "crawl-i", "stack", "stairs", "rough-ground"):
        plan = make(name)
        simulation = Simulation(plan.scene, plan.controller, time_step=plan.time_step)
        assert len(list(simulation.run(2.0 * plan.time_step))) > 1
        if plan.scene.ground is not None:
            plan.scene.ground.measure(np.zeros((1, 3)))
    for native in (True, False):
        rig(box(), material=Material(volume="exact"), native_code=native, time_step=0.01).step()
    rig(box(), tangent="conserving", time_step=0.01).step()
    rig(box(), material=Material(volume="exact"), tangent="exact", time_step=0.01).step()
    for native in (True, False):
        exact: dict[str, Any] = {"material": Material(volume="exact"), "native_code": native}
        rig(box(), elements="smoothed", time_step=0.01, **exact).step()
        rig(box(), elements="smoothed", tangent="conserving", time_step=0.01, **exact).step()
    rig(box(), elements="smoothed", time_step=0.01).step()
    rig(box(), tangent="exact", newton_iterations=2, time_step=0.01).step()
    two = SimulationOptions(newton_iterations=2)
    stack = make("stack").scene
    Simulation(stack, options=two, time_step=0.01).step()
    moved = Handle(region="cube_1", path=MotionPath.straight((1.0, 0.0, 0.0)))
    Simulation(replace(stack, handles=(moved,)), time_step=0.01).step()
    plain = rig(muscular_bar(), native_code=False, time_step=0.01)
    plain.step()
    ReducedDynamics(plain.stepper).solve(np.ones((1, 3 * plain.model.node_count)))
    for native in (True, False):
        muscles = rig(muscular_bar(), muscles="implicit", native_code=native, time_step=0.01)
        muscles.step()
        ReducedDynamics(muscles.stepper).solve(np.ones((1, 3 * muscles.model.node_count)))
    moments = np.zeros((plain.model.node_count, 4))
    segments = np.zeros(plain.model.segment_count, np.int32)
    BodySums(plain.model, moments, segments, []).observe(plain.state, plain.contacts)
    for native in (True, False):
        options: dict[str, Any] = {"preconditioner": "two_level", "native_code": native}
        large = rig(muscular_bar(), time_step=0.01, **options)
        large.step()
        ReducedDynamics(large.stepper).solve(np.ones((1, 3 * large.model.node_count)))
    for iterations in (1, 2):
        spinning = rig(box(), newton_iterations=iterations, time_step=0.01)
        spinning.place(velocities=np.cross([0.0, 0.0, 20.0], spinning.positions))
        spinning.step()
    letter = make("balance-i").scene
    striped = FrictionMap.stripes([1.0, 0.5], width=0.1)
    standing = replace(letter, ground=Plane(friction=0.8, friction_map=striped))
    Simulation(standing, time_step=0.01).step()
    step = HeightField(heights=np.array([[0.0] * 2, [0.0] * 2, [0.1] * 2, [0.1] * 2]))
    Simulation(replace(letter, ground=step), time_step=0.01).step()
    Senses(Simulation(letter, time_step=0.01), "fibers")
    # that one is compiled for the header alone
    assert {key for key, _, _ in kernels()} - launched_kernels() <= {"make_header__locals__nothing"}


def test_a_launch_with_an_output_too_few_is_refused() -> None:
    kernel = make_muscles("float32").segment_lengths
    ends = wp.zeros(1, dtype=wp.vec2i, device="cpu")
    points = wp.zeros(2, dtype=wp.vec3f, device="cpu")
    lengths = wp.zeros(1, dtype=wp.float32, device="cpu")
    with pytest.raises(ValueError, match="declares 2 inputs and 1 outputs, got 3 and 0"):
        launch(kernel, 1, [ends, points, lengths], [], "cpu")


@pytest.mark.parametrize(
    ("source", "fault"),
    [
        ("def f(a: int): ...", "argument a stands in no group"),
        ("def f(\n    # out\n    a: int,\n    # in\n    b: int,\n): ...", "in order"),
    ],
)
def test_arguments_out_of_order_are_refused(source: str, fault: str) -> None:
    with pytest.raises(ValueError, match=fault):
        argument_groups(source)
