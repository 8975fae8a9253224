"""Commands of a page as they should be, and as nobody should send them."""

from __future__ import annotations

import json
import random
from typing import Any

from warp_softbody.live.commands import FIELDS

RIGHT: list[dict[str, Any]] = [
    *({"do": name} for name, fields in FIELDS.items() if not fields),
    {"do": "speed", "value": 0.25},
    {"do": "control", "value": "static"},
    {"do": "friction", "value": 0},
    {"do": "gravity", "value": 1.62},
    {"do": "steer", "forward": 0.5, "aside": 0, "turning": -1},
    {"do": "push", "share": 0.5, "degrees": -90},
    {"do": "grab", "point": 3, "to": [0.1, 0.2, 0.3]},
    {"do": "drag", "to": [0, 0, 1e3]},
    {"do": "record", "value": True},
]
WRONG: list[Any] = [
    *(None, True, -1, 0.5, 1e300, 10**400, float("nan"), float("inf"), "", "play", [], [1], {}),
    *([1, 2], [1, 2, "3"], [1e9, 0, 0], [float("nan")] * 3, {"x": 1}, "\ud800", -0.0, 2**40),
]


def malformed(count: int) -> list[bytes]:
    """Messages that no page sends: wrong values, wrong names, cut and shuffled bytes, none."""
    chance = random.Random(7)
    made: list[bytes] = [b"", b"null", b"[]", b"{}", b"[" * 4000, b"\xff\xfe", b"{" * 4000]
    made += [b'{"do":"play"}' * 400, b'{"do":' + b"9" * 4000 + b"}", b'{"do":"play","do":1}']
    while len(made) < count:
        command = dict(chance.choice(RIGHT))
        kind = chance.randrange(5)
        if kind == 0:
            command[chance.choice(["do", "value", "to", "point", "share", "x"])] = chance.choice(
                WRONG
            )
        elif kind == 1:
            command.pop(chance.choice(list(command)))
        text = json.dumps(command).encode()
        if kind == 2:
            text = text[: chance.randrange(len(text))]
        elif kind == 3:
            text = bytes(chance.randrange(256) for _ in range(chance.randrange(60)))
        elif kind == 4:
            letters = list(text)
            chance.shuffle(letters)
            text = bytes(letters)
        made.append(text)
    return made
