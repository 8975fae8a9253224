"""Threads that use Warp at once: anything but a capture side by side, a capture alone.

Warp keeps one capture for all threads: whatever any of them launches or copies while it is open
becomes part of it. So everything that reaches Warp shares it, and a capture waits until no other
thread does.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import ParamSpec, TypeVar

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


class Turns:
    """Many threads share, or one is alone; both may be entered again by a thread that is inside."""

    def __init__(self) -> None:
        """Nobody is inside."""
        self._change = threading.Condition(threading.Lock())
        self._sharing = 0
        self._waiting = 0
        self._owner: int | None = None
        self._inside = threading.local()

    def enter(self) -> bool:
        """Be inside with others; whether the thread was not yet, and has to leave again."""
        if getattr(self._inside, "shares", False) or self._owner == threading.get_ident():
            return False
        with self._change:
            # who waits to be alone comes first, or might wait for ever
            while self._owner is not None or self._waiting:
                self._change.wait()
            self._sharing += 1
        self._inside.shares = True
        return True

    def leave(self) -> None:
        """Undo an `enter` that said so."""
        self._inside.shares = False
        with self._change:
            self._sharing -= 1
            if self._waiting:
                self._change.notify_all()

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Be inside without others; a thread that shares lets go of its share meanwhile."""
        me = threading.get_ident()
        if self._owner == me:
            yield
            return
        share = int(getattr(self._inside, "shares", False))
        with self._change:
            self._sharing -= share
            self._waiting += 1
            # others may be waiting for that share
            self._change.notify_all()
            try:
                while self._owner is not None or self._sharing:
                    self._change.wait()
                self._owner = me
            finally:
                self._waiting -= 1
                self._sharing += share
                self._change.notify_all()
        try:
            yield
        finally:
            with self._change:
                self._owner = None
                self._change.notify_all()


TURNS = Turns()


def shares_warp(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """A function during which no other thread captures."""

    @wraps(function)
    def within(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        entered = TURNS.enter()
        try:
            return function(*args, **kwargs)
        finally:
            if entered:
                TURNS.leave()

    return within
