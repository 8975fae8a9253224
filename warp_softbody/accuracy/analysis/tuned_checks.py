"""Stored settings, checked field by field: anybody may have edited their file."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any

from warp_softbody.accuracy.analysis.tuning import Tuned
from warp_softbody.accuracy.cases.settings import KNOBS, OPTIONS, Settings, as_option
from warp_softbody.errors import InputError

Check = Callable[[Any], bool]


def _number(low: float, high: float) -> Check:
    def check(value: Any) -> bool:
        return type(value) in (int, float) and low <= value <= high

    return check


def _whole(low: int, high: int) -> Check:
    return lambda value: type(value) is int and low <= value <= high


def _text(value: Any) -> bool:
    return isinstance(value, str)


def _or_none(check: Check) -> Check:
    return lambda value: value is None or check(value)


def _given(value: Any) -> bool:
    finite = _number(-1e300, 1e300)
    return isinstance(value, dict) and all(finite(number) for number in value.values())


def _texts(value: Any) -> bool:
    return isinstance(value, list | tuple) and all(isinstance(one, str) for one in value)


_POSITIVE = _number(0.0, math.inf)


def _option(knob: str, default: Any) -> Check:
    """Whether a value is one that the option of a knob takes, or None where that is its default."""

    def check(value: Any) -> bool:
        if value is None:
            return default is None
        try:
            OPTIONS[knob].check(as_option(value))
        except InputError:
            return False
        return True

    return check


SETTINGS: Mapping[str, Check] = {
    "cells": _or_none(_whole(0, 1000)),
    "level": _whole(-3, 3),
    "patches": _or_none(_whole(1, 1000)),
    **{one.name: _option(one.name, one.default) for one in fields(Settings) if one.name in OPTIONS},
}

FIELDS: Mapping[str, Check] = {
    "scene": _text,
    "given": _given,
    "seconds": _number(1e-3, 1e5),
    "bound": _number(1e-12, 1.0),
    "settings": lambda value: isinstance(value, dict),
    "error": _POSITIVE,
    "uncertainty": _POSITIVE,
    "cost": _number(0.0, 1e300),
    "default_cost": _POSITIVE,
    "default_error": _POSITIVE,
    "left_out": _texts,
    "version": _text,
    "elsewhere": _or_none(_POSITIVE),
}


def checked(values: Any, place: str) -> Tuned:
    """Tuned settings out of plain values.

    Raises:
        InputError: a field is missing, unknown, of a wrong type or out of its range; the sentence
            begins with ``place``.
    """
    if not isinstance(values, dict):
        raise InputError(f"{place} is no object")
    _check({"elsewhere": None, **values}, FIELDS, place)
    unknown = sorted(set(values["settings"]) - set(KNOBS))
    if unknown:
        raise InputError(f"{place}: settings name the knob {unknown[0]!r}")
    _check({**Settings(time_step=1.0).to_dict(), **values["settings"]}, SETTINGS, place)
    if "time_step" not in values["settings"]:
        raise InputError(f"{place} has no 'time_step'")
    tuned = Tuned.from_dict(values)
    if not tuned.settings.possible:
        raise InputError(f"{place}: smoothed elements have no exact tangent")
    return tuned


def _check(values: Mapping[str, Any], checks: Mapping[str, Check], place: str) -> None:
    unknown = sorted(set(values) - set(checks))
    if unknown:
        raise InputError(f"{place} has the field {unknown[0]!r}, which is not known")
    for name, check in checks.items():
        if name not in values:
            raise InputError(f"{place} has no {name!r}")
        if not check(values[name]):
            raise InputError(f"{place}: {name} cannot be {values[name]!r}")
