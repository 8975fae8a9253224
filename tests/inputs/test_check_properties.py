"""Whatever is given to a check comes back in the plain type, or is refused in one sentence."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks, input_kinds
from warp_softbody.inputs.records import same

LABEL = "Thing.field"
numbers = st.one_of(
    st.floats(),
    st.integers(-(2**70), 2**70),
    st.fractions(max_denominator=1000),
    st.floats(width=32).map(np.float32),
    st.integers(-(2**31), 2**31 - 1).map(np.int32),
)
others = st.one_of(
    st.none(), st.booleans(), st.text(), st.binary(), st.complex_numbers(), st.lists(st.floats())
)
anything = st.one_of(numbers, others, st.lists(others), st.dictionaries(st.text(), st.floats()))


def refusal(check: Callable[..., object], value: object, **limits: object) -> str | None:
    """The sentence of a refusal, which starts with the label; None where the value is taken."""
    try:
        check(LABEL, value, **limits)
    except InputError as error:
        sentence = str(error)
        assert sentence.startswith(LABEL) and len(sentence.splitlines()) == 1
        return sentence
    return None


@given(numbers, st.floats(-1e6, 1e6), st.floats(0.0, 1e6))
def test_numbers_in_the_range_are_taken_and_no_others(
    value: float | Fraction, low: float, width: float
) -> None:
    high = low + width
    real = float(value)
    if math.isfinite(real) and low <= real <= high:
        taken = checks.number(LABEL, value, low=low, high=high)
        assert type(taken) is float and taken == real
    else:
        assert refusal(checks.number, value, low=low, high=high)


@given(anything)
@pytest.mark.parametrize("check", [checks.number, checks.whole, checks.truth, checks.vector])
def test_anything_is_taken_or_refused_in_one_sentence(
    check: Callable[..., object], value: object
) -> None:
    refusal(check, value)


@given(anything)
def test_arrays_are_finite_numbers_or_refused(value: object) -> None:
    if refusal(array_checks.array, value, shape=None) is None:
        taken = array_checks.array(LABEL, value, None)
        assert taken.dtype == np.float64 and np.isfinite(taken).all()


@given(st.integers(-(10**12), 10**12), st.integers(0, 1000))
def test_whole_numbers_of_every_type_are_one(value: int, low: int) -> None:
    forms = (value, float(value), np.int64(value), Fraction(value))
    answers = {refusal(checks.whole, form, low=low) is None for form in forms}
    assert answers == {low <= value < 2**31}


@given(st.lists(st.floats(-1e30, 1e30), min_size=3, max_size=3))
def test_directions_have_the_length_one(parts: list[float]) -> None:
    if any(parts):
        unit = np.array(checks.direction(LABEL, parts))
        assert np.linalg.norm(unit) == pytest.approx(1.0, rel=1e-14)
        given_ = np.array(parts) / np.abs(parts).max()
        np.testing.assert_allclose(np.cross(unit, given_), 0.0, atol=1e-14)
    else:
        assert refusal(checks.direction, parts)


@given(st.integers(1, 30).flatmap(lambda n: st.lists(st.booleans(), min_size=n, max_size=n)))
def test_a_mask_and_its_indices_are_one_node_set(mask: list[bool]) -> None:
    indices = [node for node, marked in enumerate(mask) if marked]
    wanted = input_kinds.node_set(LABEL, np.array(mask), len(mask))
    forms = [indices, np.array(indices, dtype=np.float64)]
    twice = indices[::-1] + indices
    if len(twice) != len(mask) or max(twice, default=0) > 1:
        # as many zeros and ones as there are nodes are a mask
        forms.append(twice)
    if len(mask) > 2:
        forms += [np.array(mask, dtype=kind) for kind in (np.uint8, np.float32, object)]
    for form in forms:
        nodes = input_kinds.node_set(LABEL, form, len(mask))
        assert nodes.dtype == np.int32 and nodes.tolist() == wanted.tolist() == indices


@given(st.lists(st.one_of(st.integers(-3, 12), st.floats()), min_size=1), st.integers(1, 10))
def test_indices_out_of_range_are_refused(indices: list[float], count: int) -> None:
    good = all(math.isfinite(i) and i == int(i) and 0 <= i < count for i in indices)
    assert (refusal(input_kinds.node_set, indices, count=count) is None) == good


@given(anything)
def test_a_value_is_shown_on_one_short_line(value: object) -> None:
    shown = checks.shown(value)
    assert len(shown) <= checks.SHOWN + 3 and len(shown.splitlines()) <= 1


@given(st.recursive(st.one_of(numbers, st.text(), st.none()), lambda x: st.tuples(x, x)))
def test_every_value_is_the_same_as_itself(value: object) -> None:
    assert same(value, value)


@pytest.mark.parametrize("size", [1.0001e30, 1e150, 1e308])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_arrays_hold_numbers_that_are_taken_alone(size: float, sign: float) -> None:
    """In single precision what is larger would be endless; sums that cancel hide none."""
    values = np.array([[0.0, sign * size, -sign * size]])
    for form in (values, values.tolist()):
        with pytest.raises(InputError, match=r"below 1e\+30 in size, but it .* at \(0, 1\)"):
            array_checks.array(LABEL, form, (None, 3))
    array_checks.array(LABEL, values, (None, 3), finite=False)
    largest = np.full((2, 3), checks.LARGEST)
    assert array_checks.array(LABEL, largest, (None, 3)) is largest


def test_lengths_that_may_differ_have_letters_that_differ() -> None:
    with pytest.raises(InputError, match=r"of shape \(n, 3, m\), not one of shape \(2,\)"):
        array_checks.array(LABEL, [1.0, 2.0], (None, 3, None))


def test_a_number_in_place_of_its_text_is_told_apart() -> None:
    with pytest.raises(InputError, match=r"must be one of 'smooth', '4', not 4$"):
        checks.choice(LABEL, 4, ("smooth", "4"))
    with pytest.raises(InputError, match=r"must be one of 4, 8, not '8'$"):
        checks.choice(LABEL, "8", (4, 8))


def test_the_article_is_that_of_the_class() -> None:
    with pytest.raises(InputError, match=r"must be an int, not 'a'$"):
        checks.instance(LABEL, "a", int)
    with pytest.raises(InputError, match=r"must be a str, not 1$"):
        checks.instance(LABEL, 1, str)
