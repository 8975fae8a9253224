"""Files that a scene file names and that lie in a folder beside it."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

import numpy as np
import numpy.typing as npt

from warp_softbody.atomic_files import replacing
from warp_softbody.body.character import Character
from warp_softbody.errors import InputError

BEGINNING_OF_TIME = (1980, 1, 1, 0, 0, 0)
"""Of every entry of an archive, so that equal arrays give equal bytes."""


class Beside:
    """Collects what is to stand beside a file, and writes it when all is known."""

    def __init__(self, path: Path) -> None:
        """Of a scene file."""
        self._folder = path.parent / f"{path.stem}_files"
        self._data: dict[str, bytes] = {}
        self._characters: dict[str, Character] = {}

    def _place(self, name: str) -> str:
        return f"{self._folder.name}/{name}"

    def character(self, character: Character) -> str:
        """Keep a character; how the scene file names it."""
        name = f"{character.name}.char"
        self._characters[name] = character
        return self._place(name)

    def array(self, name: str, array: npt.NDArray[Any]) -> str:
        """Keep an array as a .npy file; how the scene file names it."""
        self._data[name] = _packed(array)
        return self._place(name)

    def arrays(self, name: str, arrays: dict[str, npt.NDArray[Any]]) -> str:
        """Keep arrays as an .npz file; how the scene file names it."""
        data = io.BytesIO()
        with ZipFile(data, "w", ZIP_DEFLATED) as archive:
            for key, array in arrays.items():
                entry = ZipInfo(f"{key}.npy", BEGINNING_OF_TIME)
                entry.compress_type = ZIP_DEFLATED
                archive.writestr(entry, _packed(array))
        self._data[name] = data.getvalue()
        return self._place(name)

    def write(self) -> None:
        """Write all of it, each file whole or not at all.

        Raises:
            OSError, OutputError: the folder cannot be made or written in.
        """
        if self._data or self._characters:
            self._folder.mkdir(exist_ok=True)
        for name, character in self._characters.items():
            character.save(self._folder / name)
        for name, data in self._data.items():
            with replacing(self._folder / name) as new:
                new.write_bytes(data)


def array_of_file(path: Path) -> npt.NDArray[Any]:
    """The array of a .npy file.

    Raises:
        InputError: the file is missing, or is none; one that would have to be run is refused.
    """
    try:
        return np.asarray(np.load(path, allow_pickle=False))
    except FileNotFoundError as error:
        raise InputError(f"file {path}: there is no such file") from error
    except (OSError, ValueError, EOFError) as error:
        raise InputError(f"file {path}: it is no array of NumPy: {error}") from error


def _packed(array: npt.NDArray[Any]) -> bytes:
    data = io.BytesIO()
    np.lib.format.write_array(data, np.ascontiguousarray(array), allow_pickle=False)
    return data.getvalue()
