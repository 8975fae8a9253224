"""Launches that are compared with their kernel's declaration, and how kernels group arguments.

A kernel declares its arguments in groups, each begun by a comment line: ``# model`` for what stays
constant over a run, ``# in`` for what it reads, ``# in and out`` for what it changes, ``# out`` for
what it writes. Warp itself compares types and the number of all arguments; here inputs and outputs
are counted apart, once for each launch that a graph captures.
"""

from __future__ import annotations

import ast
import textwrap
from typing import Any

import warp as wp

from warp_softbody.device.kernel_loading import can_launch

GROUPS = ("# model", "# in", "# in and out", "# out")
"""Comment lines that begin a group, in their order; a kernel may lack some."""

INPUT_GROUPS = GROUPS[:2]
"""Those whose arguments are handed to a launch as inputs; the others are outputs."""

_counts: dict[str, tuple[int, int]] = {}
"""Inputs and outputs of the kernels launched so far, by key."""


def launched_kernels() -> set[str]:
    """Keys of the kernels launched so far: factory, ``__locals__`` and kernel."""
    return set(_counts)


def argument_groups(source: str) -> dict[str, list[str]]:
    """Names of a kernel's arguments by group, in the order of the groups in its source.

    Args:
        source: of the one function, with its decorators and comments.

    Raises:
        ValueError: an argument before the first group, groups out of order, or an empty one.
    """
    function = ast.parse(textwrap.dedent(source)).body[0]
    assert isinstance(function, ast.FunctionDef)
    lines = textwrap.dedent(source).splitlines()
    groups: dict[str, list[str]] = {}
    begun = function.lineno
    for argument in function.args.args:
        for line in lines[begun : argument.lineno - 1]:
            if line.strip() in GROUPS:
                groups[line.strip()] = []
        if not groups:
            raise ValueError(f"{function.name}: argument {argument.arg} stands in no group")
        groups[next(reversed(groups))].append(argument.arg)
        begun = argument.lineno
    if list(groups) != [group for group in GROUPS if groups.get(group)]:
        raise ValueError(f"{function.name}: groups must be {GROUPS} in order, got {list(groups)}")
    return groups


def launch(
    kernel: Any, dim: int | tuple[int, ...], inputs: list[Any], outputs: list[Any], device: str
) -> None:
    """Launch a kernel over ``dim`` items; nothing where there are none.

    Raises:
        ValueError: as many inputs and outputs as the kernel does not declare.
    """
    if dim == 0 or (isinstance(dim, tuple) and 0 in dim):
        return
    if kernel.key not in _counts:
        groups = argument_groups(kernel.adj.source)
        count = sum(len(groups.get(group, ())) for group in INPUT_GROUPS)
        _counts[kernel.key] = (count, len(kernel.adj.args) - count)
    if _counts[kernel.key] != (len(inputs), len(outputs)):
        declared, given = _counts[kernel.key], (len(inputs), len(outputs))
        raise ValueError(
            f"{kernel.key} declares {declared[0]} inputs and {declared[1]} outputs, "
            f"got {given[0]} and {given[1]}"
        )
    if can_launch(device, kernel):
        wp.launch(kernel, dim=dim, inputs=inputs, outputs=outputs, device=device)
