"""Commands of a page: right ones are read, and of anything else there is one sentence."""

from __future__ import annotations

import json
from typing import Any

import pytest

from tests.live.malformed import RIGHT, malformed
from warp_softbody.errors import InputError
from warp_softbody.live.commands import FIELDS, MOST_BYTES, read_command


@pytest.mark.parametrize("command", RIGHT, ids=lambda command: str(command["do"]))
def test_right_commands(command: dict[str, Any]) -> None:
    read = read_command(json.dumps(command).encode())
    assert read.do == command["do"] and set(read.given) == set(FIELDS[read.do])


def test_every_command_is_tried() -> None:
    assert {command["do"] for command in RIGHT} == set(FIELDS)


def test_malformed_messages_are_refused_in_one_sentence() -> None:
    refused = 0
    for message in malformed(5000):
        try:
            read_command(message)
        except InputError as error:
            refused += 1
            assert "\n" not in str(error) and 5 < len(str(error)) < 600
    assert refused > 4000


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (b"{" + b" " * MOST_BYTES + b"}", "a command has at most 4096 bytes"),
        (b"play", "a command must be JSON"),
        (b'"play"', "a command must be a JSON object"),
        (b'{"do":"fly"}', "there is no command 'fly'"),
        (b'{"do":"play","value":1}', "command 'play' has these fields: none"),
        (b'{"do":"speed"}', "command 'speed' has these fields: value"),
        (b'{"do":"speed","value":9}', "value of 'speed' must be a finite number from 0.05 to 4"),
        (b'{"do":"gravity","value":NaN}', "value of 'gravity' must be a finite number of m/s\\^2"),
        (b'{"do":"grab","point":-1,"to":[0,0,0]}', "point of 'grab' must be"),
        (b'{"do":"drag","to":[1e7,0,0]}', "to of 'drag' must be within 1e\\+06 m"),
        (b'{"do":"control","value":"best"}', "value of 'control' must be one of"),
    ],
)
def test_what_is_wrong_is_told(text: bytes, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_command(text)
