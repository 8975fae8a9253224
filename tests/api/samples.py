"""A right call of every public class and function, to be spoilt one argument at a time."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

import warp_softbody as wsb
from tests.support.bodies import box
from warp_softbody import characters, controllers, live, scene_files, scenes, stage_exports
from warp_softbody.controllers.motions.crawl import BELLY_PATCHES, HEAD, TAIL
from warp_softbody.world.ground import Ground
from warp_softbody.world.view import BodyView

Samples = dict[str, tuple[Callable[..., Any], dict[str, Any]]]


@cache
def muscled() -> wsb.Character:
    """A bar with one fibre, and regions for a controller."""
    mesh = box((1, 1, 2), (0.1, 0.1, 0.2))
    fiber = wsb.Fiber(
        vertices=np.array([(0.05, 0.05, 0.02), (0.05, 0.05, 0.18)]),
        kind=wsb.FiberKind.LONGITUDINAL,
        name="fiber",
    )
    group = wsb.MuscleGroup(fibers=(fiber,), strength=1e5, kernel_width=0.05, name="group")
    low, high = mesh.points[:, 2] < 0.05, mesh.points[:, 2] > 0.15
    places = (*TAIL, *HEAD, *BELLY_PATCHES)
    patches = (*places, *(f"base_patch_{i}" for i in range(4)), "rim")
    regions: dict[str, Any] = {"base": low, "head": high, **dict.fromkeys(patches, low)}
    return wsb.Character(name="bar", mesh=mesh, muscles=(group,), regions=regions)


def character_file(folder: Path) -> Path:
    """The bar in a file."""
    muscled().save(folder / "given.char")
    return folder / "given.char"


@cache
def scene(ground: Ground | None = None) -> wsb.Scene:
    """The bar on a plane."""
    return wsb.Scene(character=muscled(), ground=ground or wsb.Plane())


@cache
def model() -> wsb.Model:
    """Of the bar, on the CPU."""
    return wsb.build_model(scene(), wsb.SimulationOptions())


@cache
def stepper() -> wsb.Stepper:
    """Of the bar; it is never asked to step."""
    return wsb.Stepper(model())


@cache
def frame() -> wsb.Frame:
    """The bar at rest."""
    return next(wsb.Simulation(scene()).run(0.01))


@cache
def recorder() -> wsb.Recorder:
    """Of one step of the bar."""
    simulation = wsb.Simulation(scene())
    kept = wsb.Recorder(simulation)
    simulation.step()
    return kept


@cache
def view() -> BodyView:
    """What a controller of the bar sees."""
    return wsb.Simulation(scene()).view()


def skin_file(folder: Path) -> Path:
    """A triangle as an .obj."""
    path = folder / "skin.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n")
    return path


def scene_file(folder: Path) -> Path:
    """A scene that ships, as a file."""
    scene_files.write(folder / "given.toml", scenes.make("topple-i"))
    return folder / "given.toml"


def contact_problem() -> dict[str, Any]:
    """Two controls and one contact."""
    return {
        "hessian": np.eye(5),
        "gradient": np.ones(5),
        "lower": np.zeros(2),
        "upper": np.ones(2),
        "velocity_offset": np.array([-0.1, 0.2, 0.0]),
        "velocity_from_controls": np.ones((3, 2)),
        "velocity_from_forces": np.eye(3),
        "friction": np.array([0.5]),
    }


@cache
def problem() -> controllers.ContactQPCC:
    """The same as an object."""
    return controllers.ContactQPCC(**contact_problem())


def engine(folder: Path) -> Samples:
    """Names of the package itself."""
    fiber, group = muscled().muscles[0].fibers[0], muscled().muscles[0]
    tets = {"points": box().points, "tets": box().tets}
    state, control = wsb.State.at_rest(model()), wsb.Control.slack(model())
    contacts = wsb.Contacts.none(model())
    triangles = {"vertices": np.eye(3), "faces": np.array([[0, 1, 2]])}
    return {
        "Environment": (wsb.Environment, {"scene": scene()}),
        "VectorEnvironment": (wsb.VectorEnvironment, {"scene": scene(), "count": 2}),
        "muscle_authority": (wsb.muscle_authority, {"character": muscled()}),
        "Batch": (wsb.Batch, {"scene": scene(), "count": 2}),
        "Batch.leave": (wsb.Batch(scene(), 2).leave, {"index": 0}),
        "Batch.run": (wsb.Batch(scene(), 2).run, {"seconds": 0.1}),
        "BatchMember": (
            wsb.BatchMember,
            {"index": 0, "scene": scene(), "random": np.random.default_rng(0)},
        ),
        "Body": (wsb.Body, {"character": muscled()}),
        "Bridge": (wsb.Bridge, {"stepper": stepper()}),
        "ReducedDynamics": (wsb.ReducedDynamics, {"stepper": stepper()}),
        "Character": (wsb.Character, {"name": "a", "mesh": box(), "muscles": ()}),
        "ContactMode": (wsb.ContactMode, {"value": 1}),
        "ContactSample": (wsb.ContactSample, {}),
        "Contacts": (wsb.Contacts, vars(contacts)),
        "Contacts.none": (wsb.Contacts.none, {"model": model()}),
        "Control": (wsb.Control, vars(control)),
        "Control.slack": (wsb.Control.slack, {"model": model()}),
        "ControlOptions": (wsb.ControlOptions, {}),
        "DirectionalFriction": (wsb.DirectionalFriction, {"region": "base"}),
        "Fiber": (wsb.Fiber, {"vertices": fiber.vertices, "kind": fiber.kind, "name": "f"}),
        "FiberKind": (wsb.FiberKind, {"value": "radial"}),
        "Frame": (wsb.Frame, {name: getattr(frame(), name) for name in vars(frame())}),
        "FrictionMap": (wsb.FrictionMap, {"factors": np.ones((3, 2))}),
        "FrictionMap.stripes": (
            wsb.FrictionMap.stripes,
            {"factors": [1.0, 0.5], "width": 0.5, "start": 0.0},
        ),
        "HeightField": (wsb.HeightField, {"heights": np.zeros((3, 2))}),
        "HeightField.measure": (wsb.HeightField(heights=np.eye(3)).measure, {"points": np.eye(3)}),
        "Material": (wsb.Material, {}),
        "MuscleGroup": (
            wsb.MuscleGroup,
            {"fibers": group.fibers, "strength": 1e5, "kernel_width": 0.1, "name": "g"},
        ),
        "Plane": (wsb.Plane, {}),
        "Plane.measure": (wsb.Plane().measure, {"points": np.eye(3)}),
        "Push": (
            wsb.Push,
            {"region": "base", "force": (1.0, 0.0, 0.0), "start": 0.0, "duration": 1.0},
        ),
        "Handle": (
            wsb.Handle,
            {"region": "head", "path": wsb.MotionPath.straight((1.0, 0.0, 0.0))},
        ),
        "UniformField": (wsb.UniformField, {"acceleration": (1.0, 0.0, 0.0), "period": 1.0}),
        "RadialField": (
            wsb.RadialField,
            {"center": (0.0, 0.0, 0.0), "acceleration": -1.0, "distance": 1.0},
        ),
        "DragField": (wsb.DragField, {"rate": 1.0}),
        "MotionPath": (
            wsb.MotionPath,
            {"times": (0.0, 1.0), "shifts": np.eye(3)[:2], "center": (0.0, 0.0, 0.0)},
        ),
        "MotionPath.straight": (wsb.MotionPath.straight, {"velocity": (1.0, 0.0, 0.0)}),
        "MotionPath.spinning": (
            wsb.MotionPath.spinning,
            {"rate": 90.0, "axis": (0.0, 0.0, 1.0), "center": (0.0, 0.0, 0.0)},
        ),
        "Scene": (wsb.Scene, {"character": muscled()}),
        "Simulation": (wsb.Simulation, {"scene": scene()}),
        "Simulation.apply_force": (
            wsb.Simulation(scene()).apply_force,
            {"nodes": [0, 1], "force": (1.0, 0.0, 0.0)},
        ),
        "Simulation.run": (wsb.Simulation(scene()).run, {"seconds": 0.1}),
        "Recorder": (wsb.Recorder, {"simulation": wsb.Simulation(scene())}),
        "Recorder.save": (recorder().save, {"path": folder / "steps.npz"}),
        "Recorder.plot": (recorder().plot, {"folder": folder / "plots"}),
        "SimulationOptions": (wsb.SimulationOptions, {}),
        "Skin": (wsb.Skin, {"points": np.eye(3), "faces": np.array([[0, 1, 2]])}),
        "Skin.read": (wsb.Skin.read, {"path": skin_file(folder)}),
        "SkinMaterial": (wsb.SkinMaterial, {}),
        "State": (wsb.State, vars(state)),
        "State.at_rest": (wsb.State.at_rest, {"model": model()}),
        "Stepper": (wsb.Stepper, {"model": model()}),
        "Stepper.step": (
            stepper().step,
            {"state": state, "control": control, "contacts": contacts, "after": state},
        ),
        "Character.from_surface": (wsb.Character.from_surface, {"surface": box(), "height": 0.4}),
        "Character.save": (muscled().save, {"path": folder / "bar.char"}),
        "Character.load": (wsb.Character.load, {"path": character_file(folder)}),
        "TetMesh": (wsb.TetMesh, tets),
        "TetMesh.from_arrays": (wsb.TetMesh.from_arrays, tets),
        "TetMesh.read": (wsb.TetMesh.read, {"path": folder / "none.vtu"}),
        "TetMesh.write": (box().write, {"path": folder / "mesh.vtu"}),
        "TriangleGround": (wsb.TriangleGround, triangles),
        "build_model": (
            wsb.build_model,
            {"scene": scene(), "options": wsb.SimulationOptions()},
        ),
        "mover": (
            wsb.mover,
            {"surface": box(), "path": wsb.MotionPath.straight((1.0, 0.0, 0.0))},
        ),
        "placed": (wsb.placed, {"character": muscled()}),
        "characters.letter_x": (characters.letter_x, {"coarse": 1}),
        "characters.make": (characters.make, {"name": "letter_i"}),
        "Setting": (
            scenes.Setting,
            {"name": "a", "default": 1.0, "low": 0.0, "high": 2.0, "help": "of it"},
        ),
    }


def control() -> Samples:
    """Names of the controllers."""
    objective = controllers.Objective(name="o", rows=np.ones((1, 54)), target=0.0, weight=1.0)  # type: ignore[arg-type]
    (patch,) = controllers.ground_patches(view(), ("base",))
    linear: dict[str, Any] = {"Q": np.eye(2), "c": np.ones(2)}
    found: Samples = {
        "ActivationCost": (controllers.ActivationCost, {}),
        "BodyUnits": (controllers.BodyUnits, {"length": 1.0, "time": 0.3}),
        "BodyUnits.of_scene": (controllers.BodyUnits.of_scene, {"scene": scene()}),
        "ContactQPCC": (controllers.ContactQPCC, contact_problem()),
        "Goals": (controllers.Goals, {"objectives": (objective,)}),
        "Combined": (controllers.Combined, {"together": (controllers.Balance(),)}),
        "Combined.goals": (
            controllers.Combined((controllers.Balance(),)).goals,
            {"view": view()},
        ),
        "Gesture": (controllers.Gesture, {"region": "base"}),
        "Gesture.goals": (controllers.Gesture(region="base").goals, {"view": view()}),
        "Motion": (controllers.Motion, {"controller": controllers.Balance()}),
        "Sequence": (controllers.Sequence, {"motions": (controllers.Balance(),)}),
        "Sequence.goals": (
            controllers.Sequence((controllers.Balance(),)).goals,
            {"view": view()},
        ),
        "Leg": (controllers.Leg, {"direction": 1.0, "turn": 1.0}),
        "Objective": (
            controllers.Objective,
            {"name": "o", "rows": np.ones((1, 54)), "target": 0.0, "weight": 1.0},
        ),
        "Patch": (
            controllers.Patch,
            {
                "weights": patch.weights,
                "gap": 0.0,
                "frame": patch.frame,
                "friction": 0.5,
                "touching": True,
            },
        ),
        "QPCC": (controllers.QPCC, linear),
        "QPCC.load": (controllers.QPCC.load, {"path": "none.npz"}),
        "Cartwheel": (controllers.Cartwheel, {}),
        "Roll": (controllers.Roll, {"legs": (), "rim": "base"}),
        "Roll.for_": (controllers.Roll.for_, {"character": muscled()}),
        "SolverOptions": (controllers.SolverOptions, {}),
        "StepGains": (controllers.StepGains, {}),
        "RecoveryGains": (controllers.RecoveryGains, {}),
        "Steering": (controllers.Steering, {}),
        "Sway": (controllers.Sway, {}),
        "TakeOff": (controllers.TakeOff, {}),
        "Trail": (controllers.Trail, {"points": np.eye(2)}),
        "Walk": (controllers.Walk, {"gait": controllers.ONE_BY_ONE}),
        **{
            f"{name}.for_": (getattr(controllers, name).for_, {"character": muscled()})
            for name in ("Balance", "Jump", "Walk")
        },
        "clustered_patches": (controllers.clustered_patches, {"view": view()}),
        "enumerate_qpcc": (controllers.enumerate_qpcc, {"problem": problem()}),
        "ground_patches": (controllers.ground_patches, {"view": view(), "regions": ("base",)}),
        "solve_qpcc": (controllers.solve_qpcc, {"problem": problem()}),
        "solve_qpcc general": (
            controllers.solve_qpcc,
            {"problem": controllers.QPCC(**linear), "budget": 4},
        ),
        "solve_static": (controllers.solve_static, {"problem": problem()}),
        "to_full": (controllers.to_full, {"problem": problem()}),
        "to_general": (controllers.to_general, {"problem": problem()}),
        "uniform_directions": (controllers.uniform_directions, {"count": 8}),
        "CrawlPhase": (controllers.CrawlPhase, {"value": "rest"}),
        "QPCCStatus": (controllers.QPCCStatus, {"value": "x"}),
    }
    for name in ("Balance", "Crawl", "Exercise", "Flip", "Jump", "Leap", "Slide"):
        found[name] = (getattr(controllers, name), {})
        found[f"{name}.goals"] = (getattr(controllers, name)().goals, {"view": view()})
    standing = ("Balance", "Cartwheel", "Crawl", "Exercise", "Flip", "Gesture")
    for name in (*standing, "Jump", "Leap", "Roll", "Slide", "Walk"):
        found[f"{name}Gains"] = (getattr(controllers, f"{name}Gains"), {})
    return found


def exports(folder: Path) -> Samples:
    """Names of the exports, with a stage of two frames to read."""
    stage = folder / "take.usdc"
    with stage_exports.StageWriter(stage, scene()) as writer:
        for each in wsb.Simulation(scene()).run(0.03):
            writer.write(each)
    take = stage_exports.read_take(stage)
    later = stage_exports.StageWriter(folder / "later.usdc", scene())
    small = (16, 16)
    return {
        "Movie": (stage_exports.Movie, {"path": folder / "a.gif", "scene": scene()}),
        "read_skin": (stage_exports.read_skin, {"path": stage}),
        "HtmlTake": (live.HtmlTake, {"path": folder / "a.html", "scene": scene()}),
        "RunOutput": (scene_files.RunOutput, {}),
        "SceneFile": (scene_files.SceneFile, {"plan": scenes.make("topple-i")}),
        "read": (scene_files.read, {"path": scene_file(folder)}),
        "write": (
            scene_files.write,
            {"path": folder / "b.toml", "content": scenes.make("topple-i")},
        ),
        "StageWriter": (
            stage_exports.StageWriter,
            {"path": folder / "a.usdc", "scene": scene()},
        ),
        "StageWriter.write": (later.write, {"frame": frame()}),
        "convert": (
            stage_exports.convert,
            {"stage": stage, "path": folder / "c.npz"},
        ),
        "body_names": (stage_exports.body_names, {"path": stage}),
        "draw_frame": (
            stage_exports.draw_frame,
            {"path": folder / "f.png", "stage": stage, "size": small},
        ),
        "draw_picture": (
            partial(stage_exports.draw_picture, folder / "a.png"),
            {"scene": scene(), "frame": frame(), "size": small},
        ),
        "draw_take": (
            stage_exports.draw_take,
            {"path": folder / "b.png", "take": take, "count": 1, "columns": 1, "size": small},
        ),
        "measure": (stage_exports.measure, {"take": take}),
        "read_take": (stage_exports.read_take, {"path": stage}),
        "recover": (stage_exports.recover, {"path": folder / "none.usdc"}),
        "take_bounds": (lambda take: stage_exports.take_bounds(take), {"take": take}),
        "reversals": (stage_exports.reversals, {"take": take}),
        "validate": (stage_exports.validate, {"path": stage}),
    }


OUTPUTS = {
    *("ControlProblem", "Model", "Measures", "Take", "FullForm", "QPCCResult", "GeneralResult"),
    *(
        "Authority",
        "ForceField",
        "GoalReport",
        # changes the process, and has a test of its own
        "quiet",
        "ContactMultipliers",
        "GeneralMultipliers",
        "Controller",
    ),
}
"""Classes that users are handed and do not make, and a protocol."""
