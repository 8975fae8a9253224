"""Who is answered: pages of the server's own, with its token; nothing else harms the session."""

from __future__ import annotations

import random
import socket
import time

import pytest

from tests.live.conftest import Client, ask, own_headers
from tests.live.malformed import malformed
from warp_softbody.errors import OutputError
from warp_softbody.live.audience import MOST_PAGES
from warp_softbody.live.server import PageServer


def raw(server: PageServer, contents: bytes) -> bytes:
    """What bytes are answered with, HTTP or not."""
    with socket.create_connection(("127.0.0.1", server.server_port), timeout=30) as connection:
        connection.sendall(contents)
        connection.shutdown(socket.SHUT_WR)
        answer = b""
        try:
            while more := connection.recv(65536):
                answer += more
        except ConnectionError:
            pass
    return answer


def test_the_page_and_its_files(page: PageServer) -> None:
    for name, kind in {
        "": "text/html",
        "page.css": "text/css",
        "live.js": "text/javascript",
    }.items():
        answer = ask(page, "GET", name)
        assert answer.status == 200 and answer.headers.get_content_type() == kind
        policy = answer.headers["Content-Security-Policy"]
        assert "default-src 'none'" in policy and "unsafe" not in policy
        assert answer.headers["Cross-Origin-Resource-Policy"] == "same-origin"
    assert ask(page, "GET", "three.min.js").headers["Content-Encoding"] == "gzip"
    assert "Server" in ask(page, "GET", "").headers


@pytest.mark.parametrize(
    "name", ["live.html/..", "../session.py", "%2e%2e/x", "vendor", "README.md"]
)
def test_no_other_file(page: PageServer, name: str) -> None:
    assert ask(page, "GET", name).status == 404


@pytest.mark.parametrize("method", ["GET", "POST"])
def test_a_wrong_token_is_refused(page: PageServer, method: str) -> None:
    token = page.access.token
    paths = ("/", "/stream", f"/{token}", f"/{token[:-1]}/stream", f"/{token}x/command", "//stream")
    for path in paths:
        answer = ask(page, method, "", b"{}", own_headers(page), path=path)
        assert answer.status == 403, path
        assert b"token" in answer.read()


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "http://example.org"},
        {"Origin": "null"},
        {"Origin": "https://127.0.0.1"},
        {"Origin": "127.0.0.1"},
        {"Host": "example.org"},
        {"Host": "127.0.0.1:1"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
    ],
)
def test_foreign_pages_are_refused(page: PageServer, headers: dict[str, str]) -> None:
    assert ask(page, "GET", "stream", headers=headers).status == 403
    posted = {**own_headers(page), **headers}
    assert ask(page, "POST", "command", b'{"do":"pause"}', posted).status == 403


def test_a_command_tells_origin_kind_and_length(page: PageServer) -> None:
    own = own_headers(page)
    without = {name: value for name, value in own.items() if name != "Origin"}
    assert ask(page, "POST", "command", b"{}", without).status == 403
    assert ask(page, "POST", "command", b"{}", {**own, "Content-Type": "text/plain"}).status == 415
    for length, status in (("-1", 411), ("1e3", 411), ("99999", 413), ("9" * 30, 411)):
        headers = {**own, "Content-Length": length}
        assert ask(page, "POST", "command", b"", headers).status == status, length
    assert ask(page, "POST", "other", b"{}", own).status == 404
    assert ask(page, "PUT", "command", b"{}", own).status == 501


def test_only_the_first_page_drives(page: PageServer) -> None:
    first, second = Client.of(page), Client.of(page)
    assert first.status["role"] == "driver" and second.status["role"] == "watcher"
    assert second.send("pause") == 409
    assert first.status["viewer"] != second.status["viewer"]
    second.read_until(lambda client: client.update is not None)
    first.close()
    second.read_until(lambda client: client.status["role"] == "driver")
    assert second.send("speed", value=1.0) == 200
    second.close()


def test_pages_without_a_name_or_with_an_invented_one(page: PageServer) -> None:
    client = Client.of(page)
    for name in ("", "x" * 16, client.status["viewer"] + "x"):
        headers = {**own_headers(page), "X-Viewer": name}
        assert ask(page, "POST", "command", b'{"do":"pause"}', headers).status == 409
    assert client.status["running"]
    client.close()


def test_there_are_only_so_many_pages(page: PageServer) -> None:
    clients = [Client.of(page) for _ in range(MOST_PAGES)]
    assert ask(page, "GET", "stream").status == 503
    for client in clients:
        client.close()
    end = time.monotonic() + 60.0
    while ask(page, "GET", "stream").status == 503:
        assert time.monotonic() < end


def test_a_thousand_malformed_messages_harm_nothing(page: PageServer) -> None:
    client = Client.of(page)
    chance = random.Random(3)
    statuses = {client.post(contents).status for contents in malformed(800)}
    assert statuses <= {200, 400, 413, 429} and 400 in statuses
    for _ in range(200):
        garbage = bytes(chance.randrange(256) for _ in range(chance.randrange(200)))
        first = b"".join([b"POST /" if chance.random() < 0.5 else b"", garbage])
        answer = raw(page, first + b"\r\n\r\n")
        assert b" 200 " not in answer.partition(b"\r\n")[0]
    assert client.send("restart") == 200 and client.send("play") == 200
    before = client.update
    client.read_until(lambda c: c.status["running"] and c.update is not before)
    client.close()


def test_a_header_without_end_and_a_silent_client(page: PageServer) -> None:
    with socket.create_connection(("127.0.0.1", page.server_port)) as silent:
        silent.sendall(b"GET / HTTP/1.1\r\nHost: ")
        assert ask(page, "GET", "").status == 200
    assert b" 431 " in raw(page, b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 200 + b"\r\n")
    assert b" 414 " in raw(page, b"GET /" + b"a" * 70_000 + b" HTTP/1.1\r\n\r\n")


def test_a_port_that_is_taken(page: PageServer) -> None:
    with pytest.raises(OutputError, match=f"port {page.server_port} of 127.0.0.1"):
        PageServer(page.server_port, finished=b"")


def test_only_this_machine_is_listened_to(page: PageServer) -> None:
    assert page.server_address[0] == "127.0.0.1"
