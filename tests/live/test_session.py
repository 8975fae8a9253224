"""A running page: what its driver asks for happens to the motion."""

from __future__ import annotations

import threading
from pathlib import Path

import numpy as np

from tests.live.conftest import Client, live_scene, served
from warp_softbody.controllers import (
    DIAGONAL_PAIRS,
    Balance,
    ControlOptions,
    Motion,
    Sequence,
    Walk,
)
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.live.audience import Audience
from warp_softbody.live.commands import Command
from warp_softbody.live.live_scene import LivePlan, LiveScene
from warp_softbody.live.session import LiveSession
from warp_softbody.scenes import make
from warp_softbody.stage_exports import read_take, validate
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene


def test_nothing_moves_while_nobody_looks_or_it_is_paused(folder: Path) -> None:
    session = LiveSession(live_scene("drop-block"), folder)
    for _ in range(3):
        session.turn()
    page = session.audience.enter()
    assert page is not None and page.update is not None
    start = page.update
    session.ask(Command("pause"))
    for _ in range(3):
        session.turn()
    assert page.update == start
    session.ask(Command("play"))
    for _ in range(20):
        session.turn()
    assert page.update != start


def test_a_page_drives_a_scene(folder: Path) -> None:
    """Pause, single steps, slow motion and restart, as its updates tell of them."""
    with served(LiveSession(live_scene("drop-block"), folder)) as server:
        client = Client.of(server)
        client.read_until(lambda c: c.update is not None and c.seen.time > 0.1)
        assert client.send("pause") == 200
        client.read_until(lambda c: not c.status["running"])
        times: list[float] = []
        for _ in range(3):
            client.read_until(lambda c: c.update is not None)
            client.update = None
            client.send("step")
            client.read_until(lambda c: c.update is not None)
            times.append(client.seen.time)
        np.testing.assert_allclose(np.diff(times), 1.0 / 120.0, atol=1e-9)
        client.send("restart")
        client.read_until(lambda c: c.update is not None and c.seen.time == 0.0)
        client.send("speed", value=0.1)
        client.read_until(lambda c: c.status["speed"] == 0.1)
        client.close()


def test_a_hand_lifts_a_body_and_its_force_is_told(folder: Path) -> None:
    """A block is pulled upwards by one of its points: it rises, and falls when it is let go."""
    with served(LiveSession(live_scene("drop-block"), folder)) as server:
        client = Client.of(server)
        client.read_until(lambda c: c.update is not None)
        top = int(np.argmax(client.seen.places[:, 2]))
        height = client.seen.places[:, 2].max()
        place = client.seen.places[top]
        client.send("grab", point=top, to=place.tolist())
        client.send("drag", to=(place + np.array((0.0, 0.0, 1.0))).tolist())
        client.read_until(lambda c: c.seen.places[:, 2].min() > height)
        numbers = client.seen.numbers
        assert numbers["pull.z"] > 0.0 and np.isfinite(numbers["hand.z"])
        assert abs(numbers["pull.x"]) < numbers["pull.z"]
        client.send("release")
        client.read_until(lambda c: np.isnan(c.seen.numbers["hand.z"]))
        client.read_until(lambda c: c.seen.places[:, 2].max() < height)
        client.close()


def test_gravity_and_friction_are_changed_on_the_way(folder: Path) -> None:
    with served(LiveSession(live_scene("drop-block"), folder)) as server:
        client = Client.of(server)
        client.send("gravity", value=0.0)
        client.send("friction", value=0.1)
        client.read_until(lambda c: c.status["gravity"] == 0.0 and c.status["friction"] == 0.1)
        client.read_until(lambda c: c.update is not None)
        client.send("push", share=0.5, degrees=90.0)
        client.read_until(lambda c: c.seen.numbers["momentum.y"] > 1.0)
        assert client.status["controls"] == ["none"]
        client.close()


def test_control_is_switched_while_it_balances(folder: Path) -> None:
    """QPCC, static and none in one motion; muscles are slack without control, QPs none."""
    session = LiveSession(live_scene("balance-i"), folder)
    with served(session) as server:
        client = Client.of(server)
        assert client.status["controls"] == ["qpcc", "static", "none"]
        assert client.status["control"] == "qpcc"
        client.read_until(lambda c: c.update is not None and c.seen.numbers["qps"] > 0.0)
        assert client.seen.numbers["ms.control"] > 0.0
        time = client.seen.time
        for method, planned in (("static", True), ("none", False), ("qpcc", True)):
            client.send("control", value=method)
            client.read_until(lambda c, m=method: c.status["control"] == m)
            client.read_until(lambda c, p=planned: (len(c.seen.patches) > 0) == p)
            assert client.seen.time >= time
            time = client.seen.time
        client.close()


def test_a_walk_is_steered(folder: Path) -> None:
    """It goes backwards, and ahead again after a restart; what does not walk is not steered."""
    assert live_scene("drop-block").steers is False
    with served(LiveSession(live_scene("walk-x-fast"), folder)) as server:
        client = Client.of(server)
        assert client.status["steering"] == [0.0, 0.0, 0.0]
        client.send("steer", forward=-1.0, aside=0.0, turning=0.0)
        client.read_until(lambda c: c.status["steering"] == [-1.0, 0.0, 0.0])
        client.read_until(lambda c: c.update is not None and c.seen.numbers["momentum.x"] < -15.0)
        client.send("restart")
        client.read_until(lambda c: c.status["steering"] == [0.0, 0.0, 0.0])
        client.read_until(lambda c: c.seen.time == 0.0)
        client.read_until(lambda c: c.seen.numbers["momentum.x"] > 15.0)
        client.close()


def test_walks_within_a_sequence_are_steered() -> None:
    """Those to come, and the one that is on, which is a copy where rounds repeat."""
    letter = make("walk-x-fast").scene.character
    motions = [
        Motion(controller=Walk(gait=DIAGONAL_PAIRS), seconds=0.2),
        Motion(controller=Balance(), seconds=0.2),
    ]

    def plan() -> LivePlan:
        return LivePlan(
            name="turns",
            scene=Scene(character=letter, ground=Plane()),
            controller=Sequence(motions, rounds=2),
            options=SimulationOptions(),
            control=ControlOptions(),
        )

    scene = LiveScene(plan, fps=60.0)
    assert scene.steers
    simulation = scene.begun()
    simulation.step()
    scene.steer(0.0, 0.0, 0.5)
    assert scene.steering == (0.0, 0.0, 0.5)
    outer = scene.plan.controller
    assert isinstance(outer, Sequence)
    walks = [own for own in outer.controllers if isinstance(own, Walk)]
    guides = {id(walk): walk.__dict__["_guide"] for walk in walks}
    assert len(guides) == 2 and len(set(map(repr, guides.values()))) == 1
    simulation.step()


def test_a_motion_is_recorded_to_a_stage(folder: Path) -> None:
    """Stages are numbered, hold what was seen, and end with the recording or the run."""
    with served(LiveSession(live_scene("drop-block"), folder)) as server:
        client = Client.of(server)
        for number in (1, 2):
            client.send("record", value=True)
            client.read_until(lambda c: c.status["recording"])
            assert client.status["file"] == f"drop-block-live-{number}.usdc"
            begun = client.update.time if client.update else 0.0
            client.read_until(lambda c, b=begun: c.update is not None and c.seen.time > b + 0.2)
            if number == 1:
                client.send("record", value=False)
            else:
                client.send("restart")
            client.read_until(lambda c: not c.status["recording"])
            assert "frames" in client.status["file"]
        client.close()
    for number in (1, 2):
        path = folder / f"drop-block-live-{number}.usdc"
        take = read_take(path)
        assert len(take) >= 4 and validate(path) == []
        np.testing.assert_allclose(np.diff(take.times), 1.0 / 30.0, atol=1e-6)
        assert np.abs(take.tet_points[-1] - take.tet_points[0]).max() > 1e-3


def test_what_cannot_be_done_is_told_and_nothing_ends(folder: Path) -> None:
    with served(LiveSession(live_scene("drop-block"), folder / "none")) as server:
        client = Client.of(server)
        client.send("record", value=True)
        client.read_until(lambda c: c.status["message"])
        assert "cannot write" in client.status["message"] and not client.status["running"]
        client.send("grab", point=10**6, to=[0, 0, 0])
        client.send("play")
        client.read_until(lambda c: c.status["running"] and not c.status["message"])
        client.close()


def test_commands_that_come_too_fast_are_refused(folder: Path) -> None:
    session = LiveSession(live_scene("drop-block"), folder)
    taken = [session.ask(Command("play")) for _ in range(300)]
    assert taken[0] and not taken[-1]
    session.turn()
    assert session.ask(Command("play"))


def test_an_audience_ends_with_its_program() -> None:
    audience = Audience(b"{}")
    page = audience.enter()
    assert page is not None and len(audience) == 1
    found: list[bytes] = []
    reader = threading.Thread(
        target=lambda: found.extend(audience.messages(page, lambda role, name: role.encode()))
    )
    reader.start()
    audience.show(b"update")
    audience.close()
    reader.join(30)
    assert not reader.is_alive() and audience.enter() is None
    assert found[0][4:] == b"\x01{}"
