"""The arrays of a QPCC: read from what is given or from files, checked, and written."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.atomic_files import replacing
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, input_kinds

LARGEST_DENSE = 2**31
"""Numbers of a matrix, 16 GB, above which a sparse one is not written out."""


def given_array(kind: str, name: str, value: object) -> FloatArray:
    """A copy of an array, a list, or a sparse matrix of SciPy written out."""
    shape = getattr(value, "shape", None)
    if hasattr(value, "toarray") and hasattr(value, "nnz") and isinstance(shape, tuple):
        if np.prod(shape, dtype=float) > LARGEST_DENSE:
            raise InputError(f"{kind}.{name} of shape {shape} is too large to be written out")
        value = value.toarray()
    if np.ma.is_masked(value):
        raise InputError(f"{kind}.{name} must have no masked numbers, which are none")
    given = array_checks.array(f"{kind}.{name}", value, None, finite=False)
    return np.array(given, np.float64, order="C")


def check_shapes(arrays: Mapping[str, FloatArray]) -> None:
    """Refuse arrays whose shapes do not go together.

    ``c`` says how many variables there are, and A, G and L how many rows, where they are given.
    """
    if arrays["c"].ndim != 1:
        raise InputError(f"QPCC.c must be of shape (n,), not {arrays['c'].shape}")
    count = arrays["c"].size
    expected: dict[str, tuple[int, ...]] = {
        "Q": (count, count),
        "lb": (count,),
        "ub": (count,),
    }
    for matrix, *others in (("A", "b"), ("G", "h", "h_lower"), ("L", "l0", "R", "r0")):
        given = arrays[matrix]
        rows = len(given) if given.ndim else 0
        rows = rows or max(len(arrays[name]) if arrays[name].ndim else 0 for name in others)
        expected[matrix] = (rows, count)
        expected.update({name: (rows, count) if name == "R" else (rows,) for name in others})
    for name, shape in expected.items():
        given = arrays[name]
        if given.shape != shape:
            raise InputError(f"QPCC.{name} must be of shape {shape}, not {given.shape}")


def check_numbers(arrays: Mapping[str, FloatArray]) -> None:
    """Refuse numbers that are none, bounds that cross and a Q that is not symmetric."""
    for name, array in arrays.items():
        bound = name in ("lb", "ub", "h", "h_lower")
        wrong = np.isnan(array) if bound else ~np.isfinite(array)
        if np.any(wrong):
            place = tuple(int(i[0]) for i in np.nonzero(wrong))
            wanted = "hold numbers" if bound else "be finite"
            raise InputError(f"QPCC.{name} must {wanted}, but it holds {array[place]} at {place}")
    for low, high, what in (("lb", "ub", "variable"), ("h_lower", "h", "row")):
        lower, upper = arrays[low], arrays[high]
        crossed = (lower > upper) | (lower == np.inf) | (upper == -np.inf)
        if np.any(crossed):
            i = int(np.argmax(crossed))
            raise InputError(
                f"QPCC.{low} and {high} of {what} {i} leave no value: {lower[i]} to {upper[i]}"
            )
    hessian = arrays["Q"]
    apart = np.abs(hessian - hessian.T)
    if float(apart.max()) > 1e-6 * float(np.abs(hessian).max()):
        i, j = (int(k) for k in np.unravel_index(int(apart.argmax()), apart.shape))
        raise InputError(
            f"QPCC.Q must be symmetric, but it holds {hessian[i, j]} at ({i}, {j}) and "
            f"{hessian[j, i]} at ({j}, {i})"
        )


def read_arrays(
    kind: str, path: str | os.PathLike[str], names: Sequence[str], needed: Sequence[str]
) -> dict[str, Any]:
    """The arrays of an ``.npz`` file that have one of the names."""
    file = input_kinds.path(f"path of {kind}.load", path)
    try:
        with np.load(file, allow_pickle=False) as data:
            if isinstance(data, np.ndarray):
                raise InputError("it is no .npz archive")
            values = {name: data[name] for name in names if name in data.files}
    # a file that is no archive of arrays fails in many ways
    except Exception as error:
        raise InputError(f"cannot read a {kind} from {os.fspath(path)}: {error}") from error
    for name in needed:
        if name not in values:
            raise InputError(f"{os.fspath(path)} holds no {kind}: {name} is missing")
    return values


def write_arrays(kind: str, path: str | os.PathLike[str], values: Mapping[str, Any]) -> None:
    """Write arrays by name into an ``.npz`` file, in one step."""
    file = input_kinds.path(f"path of {kind}.save", path)
    try:
        with replacing(file) as beside, open(beside, "wb") as stream:
            np.savez_compressed(stream, **values)
    except OSError as error:
        raise InputError(f"cannot write a {kind} to {file}: {error.strerror}") from error
