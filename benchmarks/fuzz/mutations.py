"""Ways in which a file goes wrong: on a disk, in a transfer, by hand, by another program."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

Mutation = Callable[[bytes, np.random.Generator], bytes]

NUMBERS = (
    *(b"0", b"-1", b"1", b"2", b"1.7", b"nan", b"inf", b"-inf", b"1e308", b"-1e308", b"1e-320"),
    *(b"2147483648", b"4294967299", b"99999999999999999999", b"255", b"x", b"", b"1e5", b"48"),
)
"""What a number of a text is replaced by."""


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """A file changed in one to three ways."""
    for _ in range(int(rng.integers(1, 4))):
        data = MUTATIONS[int(rng.integers(len(MUTATIONS)))](data, rng)
    return data


def _place(data: bytes, rng: np.random.Generator) -> int:
    return int(rng.integers(len(data) + 1))


def _flip_bit(data: bytes, rng: np.random.Generator) -> bytes:
    if not data:
        return data
    array = bytearray(data)
    array[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(8))
    return bytes(array)


def _other_byte(data: bytes, rng: np.random.Generator) -> bytes:
    place = _place(data, rng)
    return data[:place] + rng.bytes(1) + data[place + 1 :]


def _cut_off(data: bytes, rng: np.random.Generator) -> bytes:
    return data[: _place(data, rng)]


def _cut_out(data: bytes, rng: np.random.Generator) -> bytes:
    place = _place(data, rng)
    return data[:place] + data[place + int(rng.integers(1, 64)) :]


def _insert(data: bytes, rng: np.random.Generator) -> bytes:
    place = _place(data, rng)
    return data[:place] + rng.bytes(int(rng.integers(1, 16))) + data[place:]


def _append(data: bytes, rng: np.random.Generator) -> bytes:
    return data + rng.bytes(int(rng.integers(1, 64)))


def _zeros(data: bytes, rng: np.random.Generator) -> bytes:
    place, count = _place(data, rng), int(rng.integers(1, 64))
    return data[:place] + bytes(min(count, len(data) - place)) + data[place + count :]


def _lines(data: bytes, rng: np.random.Generator) -> tuple[list[bytes], int]:
    lines = data.splitlines(keepends=True) or [b""]
    return lines, int(rng.integers(len(lines)))


def _drop_line(data: bytes, rng: np.random.Generator) -> bytes:
    lines, index = _lines(data, rng)
    return b"".join(lines[:index] + lines[index + 1 :])


def _repeat_line(data: bytes, rng: np.random.Generator) -> bytes:
    lines, index = _lines(data, rng)
    return b"".join([*lines[:index], lines[index], *lines[index:]])


def _swap_lines(data: bytes, rng: np.random.Generator) -> bytes:
    lines, index = _lines(data, rng)
    other = int(rng.integers(len(lines)))
    lines[index], lines[other] = lines[other], lines[index]
    return b"".join(lines)


def _other_number(data: bytes, rng: np.random.Generator) -> bytes:
    found = list(re.finditer(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?", data))
    if not found:
        return data
    one = found[int(rng.integers(len(found)))]
    return data[: one.start()] + NUMBERS[int(rng.integers(len(NUMBERS)))] + data[one.end() :]


MUTATIONS: tuple[Mutation, ...] = (
    *(_flip_bit, _other_byte, _cut_off, _cut_out, _insert, _append, _zeros),
    *(_drop_line, _repeat_line, _swap_lines, _other_number, _other_number),
)
"""Numbers are changed twice as often, because that passes most checks of form."""
