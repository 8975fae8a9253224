"""`view` serves a scene or a stage until it is told to end; what it cannot show is one sentence."""

from __future__ import annotations

import json
import signal
import subprocess
from collections.abc import Callable
from http.client import HTTPConnection, HTTPResponse
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from tests.live.messages import read_take_page
from warp_softbody.characters import letter_i
from warp_softbody.cli.display import has_display
from warp_softbody.stage_exports.usd.reader import read_takes


def answer(address: str, name: str = "") -> HTTPResponse:
    parts = urlsplit(address.strip())
    assert parts.hostname == "127.0.0.1" and len(parts.path) > 30
    connection = HTTPConnection("127.0.0.1", parts.port or 0, timeout=60)
    connection.request("GET", f"{parts.path}{name}")
    return connection.getresponse()


def first_line(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline()


def test_a_scene_is_served_until_ctrl_c(start: Callable[..., subprocess.Popen[str]]) -> None:
    process = start("view", "drop-block", "--set", "height=0.4")
    address = first_line(process)
    assert b"live.js" in answer(address).read()
    stream = answer(address, "stream")
    length = int.from_bytes(stream.read(4), "little")
    outline = json.loads(stream.read(length)[1:])
    assert outline["name"] == "drop-block"
    process.send_signal(signal.SIGINT)
    assert process.wait(60) == 130
    assert process.stderr is not None
    assert process.stderr.read() == "Open this address in a browser on this machine; Ctrl-C ends.\n"


def test_a_character_is_served_that_does_something(
    start: Callable[..., subprocess.Popen[str]], tmp_path: Path
) -> None:
    letter_i(coarse=1).save(tmp_path / "i.char")
    process = start("view", tmp_path / "i.char", "--do", "jump")
    stream = answer(first_line(process), "stream")
    length = int.from_bytes(stream.read(4), "little")
    assert json.loads(stream.read(length)[1:])["name"] == "letter_i"
    process.send_signal(signal.SIGINT)
    assert process.wait(60) == 130


def test_a_stage_does_nothing(call: Any) -> None:
    told = call("view", "take.usdc", "--do", "walk")
    assert (told.code, told.err.count("\n")) == (2, 1)
    assert "a finished stage has none" in told.err


def test_a_scene_file_is_served(
    start: Callable[..., subprocess.Popen[str]], call: Any, tmp_path: Path
) -> None:
    """With its controller, a handle and a second body."""
    assert call("new", tmp_path / "my.toml").code == 0
    process = start("view", tmp_path / "my.toml")
    stream = answer(first_line(process), "stream")
    length = int.from_bytes(stream.read(4), "little")
    outline = json.loads(stream.read(length)[1:])
    assert outline["name"] == "my"
    process.send_signal(signal.SIGINT)
    assert process.wait(60) == 130


@pytest.mark.parametrize("scene", ["stack", "balance-i"])
def test_a_stage_is_played_by_the_page(
    start: Callable[..., subprocess.Popen[str]], call: Any, tmp_path: Path, scene: str
) -> None:
    """All bodies of the stage, frame by frame, with the numbers that it tells."""
    stage = tmp_path / "take.usdc"
    assert call("run", scene, "--seconds", 0.2, "--out", stage, "--quiet").code == 0
    process = start("view", stage, "--seconds", 60)
    page = answer(first_line(process))
    assert page.status == 200 and "frame-ancestors" in page.headers["Content-Security-Policy"]
    outline, updates = read_take_page(page.read().decode())
    takes = read_takes(stage)
    assert [body["name"] for body in outline["bodies"]] == [take.name for take in takes]
    assert len(updates) == len(takes[0]) == 7 and "momentum.x" not in outline["numbers"]
    for index, told in enumerate(updates):
        count = len(takes[0].skin_rest)
        error = abs(told.places[:count] - takes[0].skin_points[index]).max()
        assert error < 0.51 * told.scale + 1e-6
    assert len(updates[-1].contacts) == sum(len(take.contacts[-1].nodes) for take in takes)


def test_it_ends_by_itself_after_so_many_seconds(call: Any) -> None:
    done = call("view", "drop-block", "--seconds", 0.5)
    assert done.code == 0 and done.out.startswith("http://127.0.0.1:")


def test_a_browser_is_opened_only_where_there_is_a_display(
    call: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []

    def open_browser(address: str) -> bool:
        opened.append(address)
        return True

    monkeypatch.setattr("webbrowser.open", open_browser)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    done = call("view", "drop-block", "--seconds", 0.1, "--open")
    assert not opened and done.err.count("no browser could be opened") == 1
    monkeypatch.setenv("DISPLAY", ":0")
    assert has_display()
    done = call("view", "drop-block", "--seconds", 0.1, "--open")
    assert opened == [done.out.strip()]
    call("view", "drop-block", "--seconds", 0.1)
    assert len(opened) == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("balance",), "there is no scene 'balance'"),
        (("none.usdc",), "none.usdc"),
        (("balance-i", "--port", "70000"), "--port: must be a whole number from 0 to 65535"),
        (("balance-i", "--record", "none"), "--record: there is no folder 'none'"),
        (("balance-i", "--record", __file__), "test_view.py' is a file and no folder"),
        (("balance-i", "--set", "pull=1"), "pull"),
        (("stack", "--controller", "qpcc"), "has no controller"),
    ],
)
def test_what_cannot_be_shown_is_one_sentence(
    call: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: Any, words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    done = call("view", *arguments)
    assert done.code == 2 and words in done.err and done.err.count("\n") == 1


def test_a_run_is_written_as_a_page(call: Any, tmp_path: Path) -> None:
    page = tmp_path / "take.html"
    done = call("run", "balance-i", "--seconds", 0.2, "--html", page, "--json")
    assert done.code == 0 and json.loads(done.out)["html"] == str(page)
    outline, updates = read_take_page(page.read_text())
    assert outline["name"] == "balance-i" and len(updates) == 7
    wrong = call("run", "balance-i", "--html", tmp_path / "take.txt")
    assert wrong.code == 2 and "must end in one of .html" in wrong.err
