"""Pushes, handles and force fields of a scene file."""

from __future__ import annotations

from typing import Any

from warp_softbody.errors import InputError
from warp_softbody.scene_files.records import record_of, table_of
from warp_softbody.scene_files.tables import Table
from warp_softbody.world.force_fields import DragField, ForceField, RadialField, UniformField
from warp_softbody.world.handles import Handle
from warp_softbody.world.motion_path import MotionPath
from warp_softbody.world.scene import Push


def pushes_of(tables: list[Table]) -> tuple[Push, ...]:
    """The pushes of [[pushes]]."""
    return tuple(record_of(Push, table) for table in tables)


def handles_of(tables: list[Table]) -> tuple[Handle, ...]:
    """The handles of [[handles]], each with its path."""
    return tuple(_handle(table) for table in tables)


def _handle(table: Table) -> Handle:
    table.only(("region", "path", "until"))
    table.needed("path")
    with table.explained():
        return Handle(
            region=table.needed("region"),
            path=path_of(table.table("path")),
            until=table.take("until"),
        )


FIELDS: dict[str, type[ForceField]] = {
    "uniform": UniformField,
    "radial": RadialField,
    "drag": DragField,
}


def fields_of(tables: list[Table]) -> tuple[ForceField, ...]:
    """The fields of [[fields]]."""
    return tuple(
        record_of(FIELDS[table.choice("kind", FIELDS)], table, also=("kind",)) for table in tables
    )


def table_of_field(field: ForceField) -> dict[str, Any]:
    """What `fields_of` makes the same field of.

    Raises:
        InputError: it is none of those of the package.
    """
    kind = next((name for name, known in FIELDS.items() if type(field) is known), None)
    if kind is None:
        raise InputError(
            f"a {type(field).__name__} cannot be written to a file, only fields of the package"
        )
    return {"kind": kind, **table_of(field)}


def path_of(table: Table) -> MotionPath:
    """A path: with `velocity` or `rate` for ever, or by its times."""
    ways = [key for key in ("velocity", "rate", "times") if key in table]
    if not ways:
        table.fail("a path needs 'velocity', 'rate' or 'times'")
    if len(ways) > 1:
        table.fail(f"goes without {ways[0]!r}: a path has one of velocity, rate and times", ways[1])
    if "velocity" in table:
        table.only(("velocity",))
        with table.explained():
            return MotionPath.straight(table.take("velocity"))
    if "rate" in table:
        table.only(("rate", "axis", "center"))
        with table.explained():
            center = table.take("center")
            return MotionPath.spinning(
                table.take("rate"), table.take("axis", (0.0, 0.0, 1.0)), center=center
            )
    return record_of(MotionPath, table)


def table_of_handle(handle: Handle) -> dict[str, Any]:
    """What `handles_of` makes the same handle of."""
    path = table_of(handle.path)
    for name in ("shifts", "degrees"):
        if not getattr(handle.path, name).any():
            path.pop(name, None)
    until = {} if handle.until is None else {"until": handle.until}
    return {"region": handle.region, "path": path, **until}
