"""Reading HDF5 files that may be damaged or made to mislead: what `fbimpact` refuses is refused here as well, for it looks at them first."""

from __future__ import annotations

import os
import pathlib
from typing import Any

import h5py

from .program import FileError, call

_checked: dict[str, tuple[int, ...]] = {}


def open_file(path: pathlib.Path) -> Any:
    """Opens a result for reading, which the program has looked at since it was last written: links and data in other files, shapes and texts
    beyond what is stored, pipes, folders and versions to come. Raises `FileError` with what it said."""
    try:
        found = os.stat(path)
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror}") from None
    state = (found.st_dev, found.st_ino, found.st_mtime_ns, found.st_size)
    if _checked.get(str(path)) != state:
        call(["info", "--check", path])
        _checked[str(path)] = state
    for locking in (None, False):  # a run that goes on holds a lock on its file
        try:
            return h5py.File(path, "r", locking=locking)
        except OSError as error:
            reason = error
    raise FileError(f"{path}: cannot be read: {reason}")


def state(path: pathlib.Path) -> tuple[int, ...] | None:
    """The state of a file that `open_file` opened last: what was read in the same one need not be read again."""
    return _checked.get(str(path))
