"""Reading HDF5 files that may be damaged or made to mislead: what `fbimpact` refuses is refused here as well."""

from __future__ import annotations

import math
import os
import pathlib
import stat
from typing import Any

import h5py

from .program import FileError

HARMLESS = 1 << 24
"""Bytes up to which a dataset is read whatever is stored of it."""
LARGEST_RATIO = 1040
"""Bytes that one byte of a compressed dataset can stand for at most (deflate: 258 bytes in two bits)."""

_checked: dict[str, tuple[int, ...]] = {}


def open_file(path: pathlib.Path) -> Any:
    """Opens a file for reading. Raises `FileError` for what is none, and for contents that lie in other files or cannot be there."""
    try:
        found = os.stat(path)
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror}") from None
    if not stat.S_ISREG(found.st_mode):
        raise FileError(f"{path}: is a folder, pipe or device, name a file")
    file = _opened(path)
    state = (found.st_dev, found.st_ino, found.st_mtime_ns, found.st_size)
    if _checked.get(str(path)) != state:
        try:
            _check(file, path)
        except BaseException:
            file.close()
            raise
        _checked[str(path)] = state
    return file


def _opened(path: pathlib.Path) -> Any:
    for locking in (None, False):  # a run that goes on holds a lock on its file
        try:
            return h5py.File(path, "r", locking=locking)
        except OSError as error:
            reason = error
    raise FileError(f"{path}: cannot be read: {reason}")


def _check(file: Any, path: pathlib.Path) -> None:
    def link(name: bytes, info: Any) -> bytes | None:
        return None if info.type in (h5py.h5l.TYPE_HARD, h5py.h5l.TYPE_SOFT) else name

    def item(name: str, found: Any) -> str | None:
        if not isinstance(found, h5py.Dataset):
            return None
        if found.is_virtual or found.external:
            return f"/{name} lies in other files, which are not read; copy what they hold into this file"
        return None if _is_stored(found) else f"/{name} claims shape {found.shape}, which is more than the file holds"

    root = file["/"]
    foreign = root.id.links.visit(link, info=True)
    if foreign is not None:
        name = foreign.decode(errors="replace")
        raise FileError(f"{path}: /{name} is a link into another file, which is not followed; copy what it leads to into this file")
    try:
        fault = file.visititems(item)
    except (OSError, RuntimeError) as error:
        raise FileError(f"{path}: is damaged: {error}") from None
    if fault is not None:
        raise FileError(f"{path}: {fault}")


def _is_stored(dataset: Any) -> bool:
    """Whether the file holds as much as the shape claims."""
    size: int = math.prod(dataset.shape or (0,)) * dataset.dtype.itemsize
    if size <= HARMLESS:
        return True
    stored = int(dataset.id.get_storage_size())
    if dataset.chunks is None:
        return size <= stored
    needed: int = math.prod(-(-length // chunk) for length, chunk in zip(dataset.shape, dataset.chunks))
    return needed <= int(dataset.id.get_num_chunks()) and size // LARGEST_RATIO <= stored
