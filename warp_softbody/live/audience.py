"""Who looks at a running scene: one page drives it, others may watch."""

from __future__ import annotations

import secrets
import threading
from collections.abc import Callable, Iterator

from warp_softbody.live.wire import OUTLINE, STATUS, UPDATE, message

MOST_PAGES = 8
HEARTBEAT = 2.0
"""Seconds after which a page is sent its status again, so that one that is gone is noticed."""

StatusOf = Callable[[str, str], bytes]
DRIVER, WATCHER = "driver", "watcher"


class Page:
    """What waits to be sent to a page: the newest update, never a queue.

    Attributes:
        name: a secret that its commands bear.
    """

    def __init__(self) -> None:
        """Nothing waits yet."""
        self.name = secrets.token_urlsafe(12)
        self.update: bytes | None = None


class Audience:
    """The pages that look on; the longest there of them drives.

    The simulation's thread tells them what is new, the server's threads send it on.
    """

    def __init__(self, outline: bytes) -> None:
        """Nobody looks yet; ``outline`` is what each page is told first."""
        self._outline = outline
        self._changed = threading.Condition()
        self._pages: list[Page] = []
        self._update: bytes | None = None
        self._closed = False
        self._version = 0
        self.joined = threading.Event()

    def __len__(self) -> int:
        """How many pages look on."""
        with self._changed:
            return len(self._pages)

    def enter(self) -> Page | None:
        """A new page, or None where there are enough."""
        page = Page()
        with self._changed:
            if self._closed or len(self._pages) >= MOST_PAGES:
                return None
            page.update = self._update
            self._pages.append(page)
            self._tell()
        self.joined.set()
        return page

    def leave(self, page: Page) -> None:
        """The page is gone; the next one drives."""
        with self._changed:
            if page in self._pages:
                self._pages.remove(page)
            self._tell()
        self.joined.set()

    def role(self, name: str) -> str | None:
        """What the page of a name may do; None where there is none."""
        with self._changed:
            return self._role(name)

    def _role(self, name: str) -> str | None:
        names = [page.name for page in self._pages]
        if name not in names:
            return None
        return DRIVER if names[0] == name else WATCHER

    def show(self, update: bytes) -> None:
        """Send an update to all; one that a slow page has not taken yet is left out for it."""
        with self._changed:
            self._update = update
            for page in self._pages:
                page.update = update
            self._tell()

    def close(self) -> None:
        """Nothing more will come."""
        with self._changed:
            self._closed = True
            self._tell()

    def messages(self, page: Page, status: StatusOf) -> Iterator[bytes]:
        """What a page is sent, as it becomes known; the end of the program ends it.

        Args:
            page: that is sent to.
            status: makes the status for a role and a page's name.
        """
        yield message(OUTLINE, self._outline)
        sent: bytes | None = None
        while True:
            with self._changed:
                role = self._role(page.name)
                if self._closed or role is None:
                    return
                update, page.update = page.update, None
                seen = self._version
            told = status(role, page.name)
            if told != sent or update is None:
                sent = told
                yield message(STATUS, told)
            if update is not None:
                yield message(UPDATE, update)
            with self._changed:
                self._changed.wait_for(lambda: self._version != seen, HEARTBEAT)  # noqa: B023

    def wake(self) -> None:
        """Let the pages see a new status."""
        with self._changed:
            self._tell()

    def _tell(self) -> None:
        """Wake the threads that send, also those that are about to wait."""
        self._version += 1
        self._changed.notify_all()
