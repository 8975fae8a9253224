"""The pages in a browser without a window: `make test-viewers`; skipped where there is none."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import warp_softbody as wsb
from tests.live.conftest import live_scene, served
from tests.support.browser import Browser, browser_path
from warp_softbody.live import HtmlTake
from warp_softbody.live.server import PageServer
from warp_softbody.live.session import LiveSession

pytestmark = [
    pytest.mark.viewers,
    pytest.mark.skipif(browser_path() is None, reason="no browser is installed"),
]

POINT = """(() => {
  const { viewer } = softBody;
  const place = new THREE.Vector3().copy(viewer.center);
  place.z += 0.3 * viewer.size;
  place.project(viewer.stage.camera);
  const box = viewer.stage.renderer.domElement.getBoundingClientRect();
  return [box.left + (place.x + 1) / 2 * box.width, box.top + (1 - place.y) / 2 * box.height];
})()"""
"""Where on the page the upper half of the body is."""

SHOWN = "softBody.moment && softBody.panel && softBody.viewer.stage.drawn > 3"


@pytest.fixture
def browser(tmp_path: Path) -> Iterator[Browser]:
    with Browser(tmp_path) as found:
        yield found


@pytest.fixture(scope="module")
def balance(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PageServer]:
    folder = tmp_path_factory.mktemp("recorded")
    with served(LiveSession(live_scene("balance-i"), folder)) as server:
        yield server


def own_requests(browser: Browser, server: PageServer) -> bool:
    """Whether all that was asked for came from the server, or from the page itself."""
    own = (server.access.address, "data:", "blob:")
    return all(address.startswith(own) for address in browser.requests)


def test_a_drag_moves_the_body_and_shows_its_arrow(browser: Browser, balance: PageServer) -> None:
    browser.open(balance.access.address)
    browser.wait_for(SHOWN)
    first = browser.screenshot()
    assert not browser.value("softBody.viewer.overlays.hand.group.visible")
    x, y = browser.value(POINT)
    before = browser.value("softBody.viewer.center.x")
    browser.mouse("mousePressed", x, y)
    browser.mouse("mouseMoved", x + 60, y)
    browser.mouse("mouseMoved", x + 120, y)
    browser.wait_for("softBody.viewer.overlays.hand.group.visible")
    browser.wait_for(f"Math.abs(softBody.viewer.center.x - {before}) > 0.02")
    second = browser.screenshot()
    browser.mouse("mouseReleased", x + 120, y)
    browser.wait_for("!softBody.viewer.overlays.hand.group.visible")
    assert first != second
    assert own_requests(browser, balance) and len(browser.requests) > 10
    assert browser.errors == []


def test_pause_stops_it_and_step_moves_it_once(browser: Browser, balance: PageServer) -> None:
    browser.open(balance.access.address)
    browser.wait_for(SHOWN)
    browser.click("Pause")
    browser.wait_for("!softBody.panel.running")
    time.sleep(0.5)
    stands = browser.value("softBody.moment.time")
    time.sleep(0.5)
    assert browser.value("softBody.moment.time") == stands
    browser.click("Step")
    browser.wait_for(f"softBody.moment.time > {stands}")
    dt = balance.session._time_step if balance.session else 0.0
    assert browser.value("softBody.moment.time") == pytest.approx(stands + dt)
    browser.click("Play")
    browser.wait_for(f"softBody.moment.time > {stands + 5 * dt}")


def test_layers_controllers_and_restart(browser: Browser, balance: PageServer) -> None:
    browser.open(balance.access.address)
    browser.wait_for(SHOWN)
    boxes = "[...document.querySelectorAll('.toggle input')]"
    assert browser.value(f"{boxes}.length") == 6
    browser.value(f"{boxes}.forEach((box) => box.click())")
    layers = "Object.values(softBody.viewer.overlays.layers).flat()"
    browser.wait_for(f"{layers}.filter((part) => part.userData.off).length > 4")
    for name, method in (("Static", "static"), ("None", "none"), ("QPCC", "qpcc")):
        browser.click(name)
        browser.wait_for(f"document.querySelector('[data-value={method}]').ariaPressed === 'true'")
    before = browser.value("softBody.moment.time")
    browser.click("Restart")
    browser.wait_for(f"softBody.moment.time < {before}")
    assert browser.errors == []


TINTS = """(() => {
  const colors = softBody.viewer.ground.geometry.getAttribute("color");
  return [...new Set(Array.from({ length: colors.count }, (_, i) => colors.getX(i).toFixed(2)))];
})()"""
"""The red parts of the colours of the ground's faces."""


@pytest.mark.parametrize("steps", [0.0, 0.05])
def test_the_ground_shows_where_it_slips(browser: Browser, tmp_path: Path, steps: float) -> None:
    """Tiles of a plane and triangles of steps, as long as their layer is on."""
    scene = live_scene("walk-x", friction_stripes=0.5, steps=steps)
    with served(LiveSession(scene, tmp_path)) as server:
        browser.open(server.access.address)
        browser.wait_for(SHOWN)
        with_layer, plain = len(browser.value(TINTS)), browser.screenshot()
        browser.value("softBody.viewer.setLayer('friction', false)")
        assert with_layer > len(browser.value(TINTS)) + 2
        browser.wait_for(
            f"softBody.viewer.stage.drawn > {browser.value('softBody.viewer.stage.drawn')}"
        )
        assert browser.screenshot() != plain
    assert browser.errors == []


def test_a_narrow_page_has_no_sideways_scroll(browser: Browser, balance: PageServer) -> None:
    browser.resize(390, 844)
    browser.open(balance.access.address)
    browser.wait_for(SHOWN)
    assert browser.value("document.documentElement.scrollWidth") <= 390
    assert browser.value("softBody.frame.picture.clientHeight") > 400


def test_a_second_page_watches_and_a_wrong_token_shows_nothing(
    browser: Browser, balance: PageServer, tmp_path: Path
) -> None:
    browser.open(balance.access.address)
    browser.wait_for(SHOWN)
    (tmp_path / "second").mkdir()
    with Browser(tmp_path / "second") as second:
        second.open(balance.access.address)
        second.wait_for(SHOWN)
        assert second.value("softBody.frame.badge.textContent") == "watching"
        assert second.value("softBody.panel.sections.every((part) => part.inert)")
        second.open(balance.access.address[:-2] + "/")
        assert "token" in second.value("document.body.textContent")
    assert browser.value("softBody.frame.badge.hidden")


@pytest.fixture(scope="module")
def take(tmp_path_factory: pytest.TempPathFactory) -> Path:
    plan = wsb.scenes.make("balance-i")
    simulation = wsb.Simulation(plan.scene, plan.controller, time_step=plan.time_step)
    path = tmp_path_factory.mktemp("take") / "take.html"
    with HtmlTake(path, plan.scene, name="balance-i") as writer:
        for frame in simulation.run(1.0):
            writer.write(frame)
    return path


def test_a_take_plays_from_its_file_alone(browser: Browser, take: Path) -> None:
    browser.open(take.as_uri())
    browser.wait_for("window.softBody && softBody.player.viewer.stage.drawn > 2")
    browser.click("Pause")
    show: Callable[[int], Any] = lambda index: browser.value(  # noqa: E731
        f"(() => {{ const bar = document.querySelector('.time-range'); bar.value = {index};"
        " bar.dispatchEvent(new Event('input')); return softBody.player.index; })()"
    )
    assert show(5) == 5
    first = browser.screenshot()
    assert show(25) == 25
    assert browser.screenshot() != first
    assert browser.value("document.querySelector('.time').textContent") == "0.83 s"
    camera = browser.value("softBody.player.viewer.stage.camera.position.x")
    browser.mouse("mousePressed", 300, 200)
    browser.mouse("mouseMoved", 360, 220)
    browser.mouse("mouseReleased", 360, 220)
    assert browser.value("softBody.player.viewer.stage.camera.position.x") != camera
    browser.click("Play")
    browser.wait_for("softBody.player.index !== 25")
    assert browser.requests == [take.as_uri()] and browser.errors == []


def test_a_take_loops(browser: Browser, take: Path) -> None:
    browser.open(take.as_uri())
    browser.wait_for("window.softBody && softBody.player.index > 3")
    browser.value("softBody.player.time = softBody.player.end; softBody.player.seen = 0")
    browser.wait_for("softBody.player.time < softBody.player.end - 0.3")
    assert np.isfinite(browser.value("softBody.player.time"))
