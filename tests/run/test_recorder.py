"""What a recorder keeps of each step: against closed forms, references and the run itself."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import warp_softbody as wsb
from tests.support.bodies import box
from tests.verification import reference
from tests.verification.smoothed_reference import smoothed_energy
from tests.verification.volume_reference import smoothed_volume_energy
from warp_softbody.controllers import Balance
from warp_softbody.controllers.motions.balance_gains import LETTER
from warp_softbody.engine.energies import EnergyMeter
from warp_softbody.errors import InputError, MissingExtraError, OutputError
from warp_softbody.inputs import extras
from warp_softbody.scenes.balance_i import balancing_letter

G = 9.81
STEP = 1.0 / 60.0


@cache
def balanced() -> tuple[wsb.Recorder, wsb.Simulation]:
    """Half a second of letter I, which stands and is pushed at the end."""
    plan = wsb.scenes.make("balance-i")
    simulation = wsb.Simulation(plan.scene, plan.controller, time_step=plan.time_step)
    recorder = wsb.Recorder(simulation)
    while simulation.time < 0.55:
        simulation.step()
    return recorder, simulation


def block(height: float = 0.0, **options: object) -> wsb.Simulation:
    mesh = box((2, 2, 2), (0.2, 0.2, 0.2))
    character = wsb.placed(wsb.Character(name="block", mesh=mesh), translation=(0.0, 0.0, height))
    ground = wsb.Plane() if height == 0.0 else None
    scene = wsb.Scene(character=character, ground=ground, initial_velocity=(1.0, 0.0, 0.0))
    chosen = wsb.SimulationOptions(precision="float64", **options)  # type: ignore[arg-type]
    return wsb.Simulation(scene, options=chosen)


def test_a_free_fall_is_that_of_a_point() -> None:
    """Momentum grows by m g dt a step exactly, so x falls by dt^2 g k (k + 1) / 2."""
    simulation = block(height=5.0)
    recorder = wsb.Recorder(simulation)
    for _ in range(20):
        simulation.step()
    arrays, mass = recorder.arrays(), simulation.model.masses.sum()
    damping = simulation.model.scene.character.material.mass_damping
    assert damping == 0.0
    time = arrays["time"]
    np.testing.assert_allclose(time, simulation.model.options.time_step * np.arange(1, 21))
    expected = mass * np.stack([np.ones(20), np.zeros(20), -G * time], axis=1)
    np.testing.assert_allclose(arrays["momentum"][:, 0], expected, atol=1e-9 * mass)
    dt = time[0]
    fallen = 5.1 - G * dt**2 * np.arange(1, 21) * np.arange(2, 22) / 2.0
    np.testing.assert_allclose(arrays["centre_of_mass"][:, 0, 2], fallen, rtol=1e-9)
    np.testing.assert_allclose(arrays["angular_momentum"], 0.0, atol=1e-9 * mass)
    kinetic = 0.5 * (expected**2).sum(axis=1) / mass
    np.testing.assert_allclose(arrays["energy/kinetic"][:, 0], kinetic, rtol=1e-9)
    np.testing.assert_allclose(arrays["energy/potential"][:, 0], mass * G * fallen, rtol=1e-9)
    assert np.abs(arrays["energy/elastic"]).max() < 1e-9 * kinetic[0]
    assert arrays["contacts/step"].size == 0 and (arrays["sticking"] == 0).all()


@pytest.mark.parametrize("elements", ["linear", "smoothed"])
@pytest.mark.parametrize("volume", ["linear", "exact"])
def test_elastic_energies_are_those_of_the_references(elements: str, volume: str) -> None:
    mesh = box((2, 1, 2), (0.2, 0.1, 0.3))
    material = wsb.Material(volume=volume)  # type: ignore[arg-type]
    bodies = [wsb.Character(name=name, mesh=mesh, material=material) for name in ("a", "b")]
    other = wsb.Body(character=wsb.placed(bodies[1], translation=(1.0, 0.0, 0.0)))
    scene = wsb.Scene(character=bodies[0], others=(other,))
    options = wsb.SimulationOptions(elements=elements)  # type: ignore[arg-type]
    meter = EnergyMeter(wsb.build_model(scene, options))
    rng = np.random.default_rng(1)
    points = np.concatenate([c.mesh.points for c in scene.characters])
    points = points + 0.02 * rng.standard_normal(points.shape)
    found = meter.measure(points, np.zeros_like(points), np.zeros(0)).elastic
    halves = np.split(points, 2)
    energies = {
        ("linear", "linear"): reference.elastic_energy,
        ("smoothed", "linear"): smoothed_energy,
        ("smoothed", "exact"): smoothed_volume_energy,
    }
    if (elements, volume) == ("linear", "exact"):
        gradient = reference.deformation_gradients(mesh, halves[0])
        gap = ((gradient - reference.polar_rotations(gradient)) ** 2).sum(axis=(1, 2))
        swelling = (np.linalg.det(gradient) - 1.0) ** 2
        density = material.lame_mu * gap + 0.5 * material.lame_lambda * swelling
        assert found[0] == pytest.approx(mesh.volumes @ density, rel=1e-10)
        return
    expected = [energies[elements, volume](mesh, material, half) for half in halves]
    np.testing.assert_allclose(found, expected, rtol=1e-10)


def test_a_body_at_rest_is_borne_by_its_weight() -> None:
    simulation = block()
    recorder = wsb.Recorder(simulation)
    while not simulation.asleep:
        simulation.step()
    weight = G * simulation.model.masses.sum()
    arrays = recorder.arrays()
    np.testing.assert_allclose(
        arrays["contact_force"][-1, 0], (0.0, 0.0, weight), atol=1e-2 * weight
    )
    assert arrays["sliding"][2, 0] > 0 and arrays["sliding"][-1, 0] == 0 < arrays["sticking"][-1, 0]
    last = arrays["contacts/step"] == len(recorder) - 1
    np.testing.assert_allclose(
        arrays["contacts/force"][last].sum(axis=0), arrays["contact_force"][-1, 0], rtol=1e-12
    )
    simulation.step()
    assert len(recorder) == len(arrays["time"])


def test_goals_and_costs_of_a_controlled_run() -> None:
    recorder, simulation = balanced()
    arrays = recorder.arrays()
    parts = [
        values
        for name, values in arrays.items()
        if name.startswith("objective/") and name not in ("objective/planned", "objective/reached")
    ]
    left = np.sum(parts, axis=0)
    np.testing.assert_allclose(arrays["objective/reached"], left, rtol=1e-12)
    # what stands still does what was planned of its patches to some percent; a fall is planned too
    np.testing.assert_allclose(left[5:29], arrays["objective/planned"][5:29], rtol=0.1)
    assert (arrays["qps"] >= 1).all() and (arrays["cg_iterations"] >= 1).all()
    assert arrays["activations"].shape == (len(recorder), simulation.model.segment_count)
    assert arrays["energy/muscles"][-1, 0] > 0.0
    for part in ("assembly", "control", "solve", "contact"):
        assert (arrays[f"milliseconds/{part}"] > 0.0).all(), part


def test_muscle_energy_is_that_of_the_mean_stretch() -> None:
    """A homogeneous stretch f along a fibre of strength S stores S V / 2 (f - a)^2."""
    mesh = box((2, 2, 4), (0.1, 0.1, 0.4))
    vertices = np.array([(0.05, 0.05, 0.02), (0.05, 0.05, 0.38)])
    fiber = wsb.Fiber(vertices=vertices, kind=wsb.FiberKind.LONGITUDINAL, name="f")
    group = wsb.MuscleGroup(fibers=(fiber,), strength=1e5, kernel_width=0.1, name="g")
    scene = wsb.Scene(character=wsb.Character(name="bar", mesh=mesh, muscles=(group,)))
    meter = EnergyMeter(wsb.build_model(scene, wsb.SimulationOptions(muscles="implicit")))
    points = mesh.points * (1.0, 1.0, 1.1)
    found = meter.measure(points, np.zeros_like(points), np.array([0.8 * 0.36])).muscles
    assert found[0] == pytest.approx(0.5e5 * mesh.volumes.sum() * 0.3**2, rel=1e-9)
    slack = meter.measure(points, np.zeros_like(points), np.array([1.2 * 0.36])).muscles
    assert slack[0] == 0.0


def test_what_is_saved_reads_back(tmp_path: Path) -> None:
    recorder, _ = balanced()
    stored = np.load(recorder.save(tmp_path / "steps.npz"))
    arrays = recorder.arrays()
    assert set(stored) == {*arrays, "body_names"} and stored["body_names"].tolist() == ["letter_i"]
    for name, array in arrays.items():
        np.testing.assert_array_equal(stored[name], array)
        np.testing.assert_array_equal(recorder[name], array)


def test_plots_come_with_their_numbers(tmp_path: Path) -> None:
    from PIL import Image

    recorder, _ = balanced()
    files = recorder.plot(tmp_path / "plots")
    names = {path.stem for path in files}
    assert names == {
        *("centre_of_mass", "momentum", "angular_momentum", "contact_force", "contact_modes"),
        *("activations", "energy", "objective", "milliseconds", "solver", "plan"),
    }
    assert {path.suffix for path in files} == {".csv", ".png"}
    heading, *rows = (tmp_path / "plots" / "contact_force.csv").read_text().splitlines()
    assert heading == "time [s],x [N],y [N],z [N]" and len(rows) == len(recorder)
    numbers = np.array([[float(cell) for cell in row.split(",")] for row in rows])
    np.testing.assert_allclose(numbers[:, 1:], recorder["contact_force"][:, 0], rtol=1e-8)
    pictures = [np.asarray(Image.open(path)) for path in files if path.suffix == ".png"]
    # the plan's picture has five plots one below the other
    *alike, plan = pictures
    assert all(picture.shape == alike[0].shape for picture in alike)
    assert plan.shape[0] > 2 * alike[0].shape[0] and plan.shape[1:] == alike[0].shape[1:]
    assert all(np.ptp(picture[..., :3]) > 100 for picture in pictures)


def test_nothing_to_write_and_places_that_are_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    empty = wsb.Recorder(block())
    assert len(empty) == 0 and empty.arrays() == {}
    for write in (empty.save, empty.plot):
        with pytest.raises(InputError, match="no step was taken"):
            write(tmp_path / "a.npz")
    recorder, _ = balanced()
    with pytest.raises(InputError, match=r"must end in \.npz"):
        recorder.save(tmp_path / "a.csv")
    with pytest.raises(OutputError, match="could not be written"):
        recorder.save(tmp_path / "none" / "a.npz")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="is a file"):
        recorder.plot(tmp_path / "file")
    with pytest.raises(InputError, match="has no array 'speed'; it has: time"):
        recorder["speed"]
    monkeypatch.setattr(extras, "find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match=r"plots need matplotlib.*warp-softbody\[charts\]"):
        recorder.plot(tmp_path / "plots")


@pytest.mark.parametrize("controlled", [("letter_i", "other"), ("other",)], ids=str)
def test_goals_and_plans_are_those_of_the_body_that_is_controlled(
    controlled: tuple[str, ...],
) -> None:
    """Of the first one, beside another one with muscles of its own, as if it were alone."""
    letter = balancing_letter()
    other = replace(wsb.placed(letter, translation=(2.0, 0.0, 0.0)), name="other")
    beside = wsb.Scene(character=letter, others=(wsb.Body(character=other),), ground=wsb.Plane())
    alone = wsb.Scene(character=other if controlled == ("other",) else letter, ground=wsb.Plane())
    found = []
    for scene, names in ((beside, controlled), (alone, ("letter_i",))):
        first = Balance(LETTER) if "letter_i" in names else None
        others = {"other": Balance(LETTER)} if "other" in names else {}
        options = wsb.SimulationOptions(precision="float64", tolerance=1e-10, time_step=STEP)
        simulation = wsb.Simulation(scene, first, others=others, options=options)
        recorder = wsb.Recorder(simulation)
        for _ in range(24):
            simulation.step()
        plans = simulation.summary().plans
        assert plans is not None and plans.momentum is not None
        rows = [row.reached for row in simulation.goal_report().outcomes]
        found.append((recorder.arrays(), np.array(rows), plans.momentum))
    (one, reached, missed), (expected, wanted, least) = found
    told = [name for name in expected if name.startswith(("plan/", "objective/"))]
    assert told
    for name in told:
        size = np.nanmax(np.abs(expected[name]))
        np.testing.assert_allclose(one[name], expected[name], atol=1e-2 * size + 1e-6, err_msg=name)
    np.testing.assert_allclose(reached, wanted, atol=1e-3 * np.abs(wanted).max())
    assert missed == pytest.approx(least, abs=1e-3)
