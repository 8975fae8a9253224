"""Messages between processes arrive whole, in order, and the end of one side is told."""

from __future__ import annotations

from threading import Thread

import pytest

from warp_softbody.stage_exports.usd.messages import Messages


def test_messages_arrive_whole_and_in_order() -> None:
    ours, theirs = Messages.pair()
    assert not theirs.has_any()
    # the last are more than a socket holds
    given = [("frames", [(0, 5)]), ValueError("no"), b"x" * 3_000_000, None]

    def send() -> None:
        for message in given:
            ours.send(message)

    sender = Thread(target=send)
    sender.start()
    found = [theirs.receive() for _ in given]
    sender.join()
    assert found[0] == given[0] and repr(found[1]) == repr(given[1]) and found[2:] == given[2:]
    assert not theirs.has_any()


def test_the_end_of_the_other_side_is_told() -> None:
    ours, theirs = Messages.pair()
    ours.send("last")
    ours.close()
    assert theirs.has_any() and theirs.receive() == "last"
    assert theirs.has_any()
    with pytest.raises(EOFError):
        theirs.receive()
    with pytest.raises(BrokenPipeError):
        theirs.send("nobody hears")
