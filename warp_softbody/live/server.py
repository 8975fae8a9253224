"""Serves one page on this machine: its files, a stream of messages, and commands that are posted.

Python's own HTTP server does: a page reads one endless answer and posts what it wants, so that no
other protocol is needed. Each connection has a thread; none of them touches the simulation.
"""

from __future__ import annotations

import socketserver
import threading
from contextlib import suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from warp_softbody.errors import InputError, OutputError
from warp_softbody.live.access import FRAMES, HEADERS, POLICY, Access
from warp_softbody.live.audience import DRIVER
from warp_softbody.live.commands import MOST_BYTES, read_command
from warp_softbody.live.page_files import THREE, TYPES, served
from warp_softbody.live.session import LiveSession

HOST = "127.0.0.1"
SILENCE = 20.0
"""Seconds that a connection may be silent, or not take what it is sent."""


class PageServer(ThreadingHTTPServer):
    """Answers at a port of this machine.

    Attributes:
        access: who may ask.
        session: what is shown; None where a finished page is.
        finished: that page, and the policy that it needs.
    """

    daemon_threads = True
    block_on_close = False
    request_queue_size = 64

    def __init__(
        self, port: int, *, session: LiveSession | None = None, finished: bytes = b""
    ) -> None:
        """Listen at a port, or at a free one where it is 0.

        Raises:
            OutputError: the port is taken.
        """
        try:
            super().__init__((HOST, port), Answer)
        except OSError as error:
            why = error.strerror or str(error)
            raise OutputError(f"port {port} of {HOST} cannot be listened at: {why}") from error
        self.access = Access(self.server_address[1])
        self.session = session
        self.finished = finished

    def server_bind(self) -> None:
        """Bind without asking any name server for the machine's name."""
        socketserver.TCPServer.server_bind(self)
        self.server_name, self.server_port = HOST, self.server_address[1]

    def begin(self) -> None:
        """Answer from now on, in a thread of its own."""
        threading.Thread(target=self.serve_forever, name="page-server", daemon=True).start()

    def end(self) -> None:
        """Answer no more."""
        self.shutdown()
        self.server_close()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A connection that breaks harms nobody, and nobody is told."""


class Answer(BaseHTTPRequestHandler):
    """Answers one connection."""

    server: PageServer
    protocol_version = "HTTP/1.1"
    server_version = "warp-softbody"
    sys_version = ""
    timeout = SILENCE
    error_message_format = "%(code)d %(message)s\n"
    error_content_type = "text/plain; charset=utf-8"

    def do_GET(self) -> None:
        """The page, one of its files, or the stream."""
        name = self._asked(posts=False)
        if name is None:
            return
        files = served()
        if self.server.session is None:
            files = {"": self.server.finished}
        elif name == "stream":
            self._stream(self.server.session)
            return
        else:
            files = {**files, "": files["live.html"]}
        if name not in files:
            self._refuse(HTTPStatus.NOT_FOUND, "there is no such file")
            return
        suffix = name[name.rfind(".") :] if name else ".html"
        self._send(HTTPStatus.OK, files[name], TYPES[suffix], packed=name == THREE)

    def do_POST(self) -> None:
        """A command."""
        name = self._asked(posts=True)
        if name is None:
            return
        session = self.server.session
        if name != "command" or session is None:
            self._refuse(HTTPStatus.NOT_FOUND, "there is nothing to post to")
            return
        contents = self._contents()
        if contents is None:
            return
        try:
            command = read_command(contents)
        except InputError as error:
            self._refuse(HTTPStatus.BAD_REQUEST, str(error))
            return
        if session.audience.role(self.headers.get("X-Viewer", "")) != DRIVER:
            self._refuse(HTTPStatus.CONFLICT, "another page drives this scene")
        elif not session.ask(command):
            self._refuse(HTTPStatus.TOO_MANY_REQUESTS, "too many commands wait")
        else:
            self._send(HTTPStatus.OK, b"", "text/plain")

    def _asked(self, *, posts: bool) -> str | None:
        """What is asked for; None where it was refused."""
        refusal = self.server.access.refusal(self.headers, posts=posts)
        name = None if refusal else self.server.access.name_of(self.path)
        if name is None:
            self._refuse(HTTPStatus.FORBIDDEN, refusal or "the token of the address is wrong")
        return name

    def _contents(self) -> bytes | None:
        """The body of a request; None where it was refused."""
        if self.headers.get("Content-Type") != "application/json":
            self._refuse(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "a command is application/json")
            return None
        told = self.headers.get("Content-Length", "")
        if not (told.isascii() and told.isdigit()) or len(told) > 9:
            self._refuse(HTTPStatus.LENGTH_REQUIRED, "a command must tell its length")
            return None
        if int(told) > MOST_BYTES:
            self._refuse(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "a command is short")
            return None
        return self.rfile.read(int(told))

    def _stream(self, session: LiveSession) -> None:
        """Send messages until the page is gone or the program ends."""
        page = session.audience.enter()
        if page is None:
            self._refuse(HTTPStatus.SERVICE_UNAVAILABLE, "too many pages look at this scene")
            return
        self.close_connection = True
        try:
            self._head(HTTPStatus.OK, "application/octet-stream")
            self.send_header("Connection", "close")
            self.end_headers()
            for message in session.audience.messages(page, session.status):
                self.wfile.write(message)
        except OSError:
            # the page is gone, or takes nothing
            pass
        finally:
            session.audience.leave(page)

    def _send(
        self, status: HTTPStatus, contents: bytes, kind: str, *, packed: bool = False
    ) -> None:
        self._head(status, kind)
        if packed:
            self.send_header("Content-Encoding", "gzip")
        self.send_header("Content-Length", str(len(contents)))
        if self.close_connection:
            self.send_header("Connection", "close")
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(contents)

    def _head(self, status: HTTPStatus, kind: str) -> None:
        self.send_response(status)
        text = "; charset=utf-8" if kind.startswith("text/") else ""
        self.send_header("Content-Type", kind + text)
        # a finished page brings the policy for what is written into it
        own = self.server.session is None and kind == TYPES[".html"]
        self.send_header("Content-Security-Policy", FRAMES if own else POLICY)
        for name, value in HEADERS.items():
            self.send_header(name, value)

    def _refuse(self, status: HTTPStatus, sentence: str) -> None:
        """Answer with a sentence; what else the connection holds is not read."""
        self.close_connection = True
        with suppress(OSError):
            self._send(status, f"{sentence}\n".encode(), "text/plain")

    def log_message(self, format: str, *args: Any) -> None:
        """Tell nobody."""
