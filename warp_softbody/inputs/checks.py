"""One check for each kind of value that a user gives; a wrong one is refused in one sentence.

Every check takes a label, such as ``Material.young_modulus``, and the value; it returns the value
in the plain type that the engine works with, or raises an InputError that names label and value.
Checks of arrays are in `array_checks`, those of node sets, names and other things with a structure
of their own in `input_kinds`.
"""

from __future__ import annotations

import inspect
import math
import sys
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from numbers import Rational, Real
from types import FunctionType
from typing import Any, NoReturn, TypeVar

from warp_softbody.errors import InputError

Kind = TypeVar("Kind")

UNIT_ROUNDING = 1e-15
"""By which the length of a vector that was divided by its length differs from one, at most."""

LARGEST = 1e30
"""Size beyond which no number is taken: single precision ends at 3e38."""

SHOWN = 80
"""Characters of a wrong value that its sentence repeats."""

MOST_ITEMS = 8
"""Items of an array beyond which its sentence has their number alone."""


def shown(value: object) -> str:
    """A value as a sentence shows it: short, on one line, whatever it is."""
    numpy = sys.modules.get("numpy")
    if numpy is not None and isinstance(value, numpy.ndarray) and value.size > MOST_ITEMS:
        return f"an array of shape {value.shape} and type {value.dtype}"
    try:
        text = " ".join(repr(value).split())
    except Exception:
        # a stranger's __repr__ may raise anything
        text = f"an object of the type {type(value).__name__}"
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}..."


def refuse(label: str, wanted: str, value: object) -> NoReturn:
    """Raise the sentence that tells what was wanted and what was given."""
    raise InputError(f"{label} must be {wanted}, not {shown(value)}")


def plain(value: object) -> object:
    """The Python object that a NumPy scalar or an array of no dimension holds."""
    # what is of NumPy has loaded it; the command line's help does without
    numpy = sys.modules.get("numpy")
    if numpy is None or not isinstance(value, numpy.generic | numpy.ndarray) or value.ndim:
        return value
    held: object = value.item()
    return held


def number(
    label: str,
    value: object,
    *,
    low: float = -LARGEST,
    high: float = LARGEST,
    above: float = -math.inf,
    below: float = math.inf,
    infinite: bool = False,
    unit: str = "",
) -> float:
    """A finite number from ``low`` to ``high``, ends included, and between ``above`` and ``below``.

    Integers, floats, fractions and their NumPy forms are numbers; truth values and texts are not.
    With ``infinite`` an endless one is taken too.

    Raises:
        InputError: it is none, or outside the range.
    """
    if isinstance(value, float) and low <= value <= high and above < value < below:
        return float(value)
    given = plain(value)
    real = math.nan
    if isinstance(given, Real) and not isinstance(given, bool):
        with suppress(OverflowError, ValueError, TypeError):
            real = float(given)
    if infinite and real == math.inf:
        return real
    if not (math.isfinite(real) and low <= real <= high and above < real < below):
        wanted = _wanted(low, high, above, below, unit)
        if math.isfinite(real) and abs(real) > LARGEST:
            wanted = f"{wanted} and below {LARGEST:g} in size"
        refuse(label, wanted, value)
    return real


def _wanted(low: float, high: float, above: float, below: float, unit: str) -> str:
    """What a number has to be, in words."""
    kind = "a positive number" if above == 0.0 else "a finite number"
    text = f"{kind} of {unit}" if unit else kind
    if low > -LARGEST and high < LARGEST:
        return f"{text} from {low:g} to {high:g}"
    bounds = []
    if low > -LARGEST:
        bounds.append(f"at least {low:g}")
    if high < LARGEST:
        bounds.append(f"at most {high:g}")
    if math.isfinite(above) and above != 0.0:
        bounds.append(f"above {above:g}")
    if math.isfinite(below):
        bounds.append(f"below {below:g}")
    return f"{text}, {' and '.join(bounds)}" if bounds else text


def whole(label: str, value: object, *, low: int = 0, high: int = 2**31 - 1) -> int:
    """A whole number from ``low`` to ``high``; 2.0 is one, 1.7 and True are not."""
    given = plain(value)
    count = None
    if isinstance(given, Rational) and not isinstance(given, bool) and given.denominator == 1:
        count = int(given.numerator)
    elif isinstance(given, float) and given.is_integer():
        count = int(given)
    if count is None or not low <= count <= high:
        bounds = f"from {low} to {high}" if high < 2**31 - 1 else f"of at least {low}"
        refuse(label, f"a whole number {bounds}", value)
    return count


def truth(label: str, value: object) -> bool:
    """True or False."""
    given = plain(value)
    if not isinstance(given, bool):
        refuse(label, "True or False", value)
    return given


def choice(label: str, value: object, known: Iterable[Kind]) -> Kind:
    """One of a few known values."""
    options = tuple(known)
    given = plain(value)
    for option in options:
        if type(given) is type(option) and given == option:
            return option
    written = [str(option) for option in options]
    if shown(given) in written or (isinstance(given, str) and given in written):
        # a number in the place of its text, or the other way round
        written = [repr(option) for option in options]
    refuse(label, f"one of {', '.join(written)}", value)


def instance(label: str, value: object, kind: type[Kind]) -> Kind:
    """An object of a class."""
    if not isinstance(value, kind):
        if value is kind:
            refuse(
                label,
                f"an object of the class {kind.__name__}, made by {kind.__name__}(...)",
                value,
            )
        refuse(label, f"{article(kind.__name__)} {kind.__name__}", value)
    return value


def article(name: str) -> str:
    """The indefinite article before the name of a class."""
    return "an" if name[:1] in "AEIOaeio" else "a"


def optional(label: str, value: Kind | None, kind: type[Kind]) -> Kind:
    """An object of a class, or one made without arguments where None is given."""
    return kind() if value is None else instance(label, value, kind)


def items(label: str, value: object, kind: type[Kind]) -> tuple[Kind, ...]:
    """Several objects of a class, in a tuple, a list or whatever else can be walked through."""
    # told fast, for what is made in every step
    if type(value) is tuple and all(type(item) is kind for item in value):
        return value
    wanted = f"a tuple of {kind.__name__} objects"
    if isinstance(value, kind):
        refuse(label, wanted, value)
    given = several(label, value, wanted)
    return tuple(instance(f"{label}[{i}]", item, kind) for i, item in enumerate(given))


def several(label: str, value: object, wanted: str) -> list[Any]:
    """What a tuple, a list or an array holds; a text or a dictionary is one thing."""
    if isinstance(value, str | bytes | Mapping) or not isinstance(value, Iterable):
        refuse(label, wanted, value)
    try:
        return list(value)
    except Exception:
        # an array of no dimension, or a stranger whose iterator fails
        refuse(label, wanted, value)


def vector(label: str, value: object, size: int = 3, *, unit: str = "") -> tuple[float, ...]:
    """So many finite numbers, as a tuple of floats."""
    parts = several(label, value, _numbers(size, unit))
    if len(parts) != size:
        refuse(label, _numbers(size, unit), value)
    try:
        return tuple(number(label, part) for part in parts)
    except InputError:
        refuse(label, _numbers(size, unit), value)


def _numbers(size: int, unit: str) -> str:
    return f"{size} finite numbers{f' of {unit}' if unit else ''}"


def direction(label: str, value: object, size: int = 3) -> tuple[float, ...]:
    """A unit vector along a vector that is finite and not zero."""
    parts = vector(label, value, size)
    largest = max(abs(part) for part in parts)
    if largest == 0.0:
        refuse(label, "a vector that is not zero", value)
    length = math.sqrt(sum(part * part for part in parts))
    if abs(length - 1.0) <= UNIT_ROUNDING:
        # as it is, so that one that was made a unit vector here stays the same to the last bit
        return tuple(parts)
    if 0.0 < length < math.inf and largest > 1e-100:
        return tuple(part / length for part in parts)
    scaled = [part / largest for part in parts]
    length = math.sqrt(sum(part * part for part in scaled))
    return tuple(part / length for part in scaled)


def function(label: str, value: object, wanted: str) -> Callable[..., Any]:
    """Something that can be called."""
    if not callable(value):
        refuse(label, wanted, value)
    return value


def called_with(label: str, value: object, count: int, wanted: str) -> Callable[..., Any]:
    """A function that takes a number of arguments by place."""
    given = function(label, value, wanted)
    # told fast, for what is asked for in every step
    if type(given) is FunctionType:
        code = given.__code__
        if code.co_argcount == count and not code.co_kwonlyargcount:
            return given
    try:
        inspect.signature(given).bind(*range(count))
    except (TypeError, ValueError):
        refuse(label, wanted, value)
    return given


def keep(record: object, **values: object) -> None:
    """Store checked values in the fields of a frozen dataclass."""
    for name, value in values.items():
        object.__setattr__(record, name, value)


def settle(
    record: object,
    *,
    positive: Iterable[str] = (),
    not_negative: Iterable[str] = (),
    finite: Iterable[str] = (),
    vectors: Iterable[str] = (),
) -> None:
    """Check number fields of a frozen dataclass and keep them as floats, or tuples of three."""
    owner = type(record).__name__
    for name in positive:
        keep(record, **{name: number(f"{owner}.{name}", getattr(record, name), above=0.0)})
    for name in not_negative:
        keep(record, **{name: number(f"{owner}.{name}", getattr(record, name), low=0.0)})
    for name in finite:
        keep(record, **{name: number(f"{owner}.{name}", getattr(record, name))})
    for name in vectors:
        keep(record, **{name: vector(f"{owner}.{name}", getattr(record, name))})
