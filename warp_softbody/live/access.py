"""Who may speak with the server: pages that it has served itself, and nobody else.

The address of a page holds a token of 192 random bits as its first folder, so that scripts, styles
and the stream are asked for beside it without any other sign, and no page of another origin can
name them. Host and origin are checked all the same: a name of another site that was pointed at
127.0.0.1 does not reach it.
"""

from __future__ import annotations

import hmac
import secrets
from email.message import Message

FRAMES = "frame-ancestors 'none'"
"""No page may show one of ours within it."""

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    f"img-src data:; base-uri 'none'; form-action 'none'; {FRAMES}"
)
"""What a live page may load: its own files, and nothing that is written into it."""

HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store",
}


class Access:
    """The token of a server and the origins that may use it.

    Attributes:
        token: part of every address.
    """

    def __init__(self, port: int) -> None:
        """For a server at a port of this machine."""
        self.token = secrets.token_urlsafe(24)
        self._hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}
        self.address = f"http://127.0.0.1:{port}/{self.token}/"

    def name_of(self, path: str) -> str | None:
        """What a path asks for below the token; None where the token is another one."""
        token, slash, name = path.lstrip("/").partition("/")
        right = hmac.compare_digest(token.encode("utf-8", "replace"), self.token.encode())
        return name.partition("?")[0] if right and slash else None

    def refusal(self, headers: Message, *, posts: bool) -> str | None:
        """Why a request is not answered, from its headers; None where it is.

        Args:
            headers: of the request.
            posts: whether it wants something done; then it must tell its origin.
        """
        if headers.get("Host") not in self._hosts:
            return "this server is reached as 127.0.0.1 only"
        origin = headers.get("Origin")
        if origin is None:
            if posts:
                return "a command must tell the origin of its page"
        elif origin.removeprefix("http://") not in self._hosts or "://" not in origin:
            return "pages of another origin are not served"
        site = headers.get("Sec-Fetch-Site")
        return (
            None
            if site in (None, "none", "same-origin")
            else "pages of another site are not served"
        )
