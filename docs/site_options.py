"""The docstrings of option classes on the site, as Python has them.

The decorator `described` adds to the docstring of an option class what its fields say of
themselves, which a reader of the source alone does not see.
"""

import inspect
from importlib import import_module
from typing import Any

import griffe


class OptionDocstrings(griffe.Extension):
    """Takes the docstrings of classes that are described by their fields from the classes."""

    def on_class(self, *, cls: griffe.Class, **_: Any) -> None:
        """Replace a docstring, where the class has the decorator."""
        described = any(str(decorator.value) == "described" for decorator in cls.decorators)
        if described and cls.docstring is not None:
            owner = getattr(import_module(cls.module.path), cls.name)
            cls.docstring.value = inspect.getdoc(owner) or ""
