"""A running page of a small scene, and a client that speaks HTTP byte by byte."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from http.client import HTTPConnection, HTTPResponse
from pathlib import Path
from typing import Any

import pytest

import warp_softbody as wsb
from tests.live.messages import Told, read_update
from warp_softbody.live.live_scene import LivePlan, LiveScene
from warp_softbody.live.server import PageServer
from warp_softbody.live.session import FPS, LiveSession


def live_scene(name: str, **settings: float) -> LiveScene:
    """A shipped scene as `view` runs it, with settings."""

    def make() -> LivePlan:
        plan = wsb.scenes.make(name, settings)
        control = None if plan.controller is None else wsb.ControlOptions()
        precision: Any = "float64" if name == "cantilever" else "float32"
        options = wsb.SimulationOptions(
            time_step=min(plan.time_step, 1.0 / 60.0), precision=precision
        )
        return LivePlan(
            name=name,
            scene=plan.scene,
            controller=plan.controller,
            options=options,
            control=control,
        )

    return LiveScene(make, FPS)


@dataclass
class Client:
    """A page of its own, without a browser.

    Attributes:
        server: that it speaks to.
        response: the stream.
        outline: that it was told.
        status: the last one.
        update: the last one.
    """

    server: PageServer
    response: HTTPResponse
    outline: dict[str, Any]
    status: dict[str, Any]
    update: Told | None = None

    @property
    def seen(self) -> Told:
        """The last update; there must be one."""
        assert self.update is not None
        return self.update

    @staticmethod
    def of(server: PageServer) -> Client:
        """Open the stream and read until the first status."""
        response = ask(server, "GET", "stream")
        assert response.status == 200, response.read()
        client = Client(server, response, {}, {})
        while not client.status:
            client.read()
        return client

    def read(self) -> int:
        """Read one message; return its kind."""
        length = int.from_bytes(self.response.read(4), "little")
        contents = self.response.read(length)
        assert length and len(contents) == length, "the stream has ended"
        kind, contents = contents[0], contents[1:]
        if kind == 1:
            self.outline = json.loads(contents)
        elif kind == 2:
            self.update = read_update(contents, self.outline)
        else:
            self.status = json.loads(contents)
        return kind

    def read_until(self, wanted: Any) -> None:
        """Read until a function of this client is true."""
        for _ in range(2000):
            if wanted(self):
                return
            self.read()
        raise AssertionError(f"never: {self.status}")

    def send(self, do: str, **fields: Any) -> int:
        """Post a command; return the status of the answer."""
        return self.post(json.dumps({"do": do, **fields}).encode()).status

    def post(self, contents: bytes) -> HTTPResponse:
        """Post anything."""
        headers = {"X-Viewer": self.status["viewer"], **own_headers(self.server)}
        return ask(self.server, "POST", "command", contents, headers)

    def close(self) -> None:
        """Go away."""
        self.response.close()


def own_headers(server: PageServer) -> dict[str, str]:
    """Those that a page of the server sends with a command."""
    origin = f"http://127.0.0.1:{server.server_port}"
    return {"Origin": origin, "Content-Type": "application/json"}


def ask(
    server: PageServer,
    method: str,
    name: str,
    body: bytes | None = None,
    headers: dict[str, str] | None = None,
    *,
    path: str | None = None,
) -> HTTPResponse:
    """The answer to a request below the token, or to one of another path."""
    connection = HTTPConnection("127.0.0.1", server.server_port, timeout=60)
    target = f"/{server.access.token}/{name}" if path is None else path
    connection.request(method, target, body, headers or {})
    return connection.getresponse()


@contextmanager
def served(session: LiveSession) -> Iterator[PageServer]:
    """A session that runs in a thread, and its server."""
    server = PageServer(0, session=session)
    server.begin()
    thread = threading.Thread(target=session.run)
    thread.start()
    try:
        yield server
    finally:
        session.end()
        thread.join(60)
        server.end()
        assert not thread.is_alive()


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PageServer]:
    """A falling block, which needs no control."""
    folder = tmp_path_factory.mktemp("recorded")
    with served(LiveSession(live_scene("drop-block"), folder)) as server:
        yield server


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Where a session records to."""
    return tmp_path
