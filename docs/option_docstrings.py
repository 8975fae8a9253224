"""Docstrings of option classes, which are made of their fields when the module is loaded."""

import inspect
from importlib import import_module
from typing import Any

import griffe

FIELDS = "warp_softbody.inputs.option_fields"


class OptionDocstrings(griffe.Extension):
    """Gives the classes that `option_fields.described` decorates the docstrings that it makes."""

    def on_class(self, *, cls: griffe.Class, **_: Any) -> None:
        """Replace the docstring that stands in the source."""
        if any(one.callable_path == f"{FIELDS}.described" for one in cls.decorators):
            made = getattr(import_module(cls.module.path), cls.name)
            cls.docstring = griffe.Docstring(inspect.getdoc(made) or "", parent=cls)
