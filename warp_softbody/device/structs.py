"""Warp structs of kernel arguments, filled from records of device arrays."""

from __future__ import annotations

from typing import Any


def struct_of(kind: Any, source: object = None, **others: Any) -> Any:
    """A struct of a kind, every field of it from ``others`` or an attribute of ``source``.

    Raises:
        AttributeError: a field of the struct that neither has.
        TypeError: something among ``others`` that is no field of the struct.
    """
    unknown = others.keys() - kind.vars.keys()
    if unknown:
        raise TypeError(f"{kind.cls.__name__} has no field {', '.join(sorted(unknown))}")
    struct = kind()
    for name in kind.vars:
        setattr(struct, name, others[name] if name in others else getattr(source, name))
    return struct
