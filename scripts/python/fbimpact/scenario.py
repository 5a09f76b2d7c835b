"""Scenarios as dictionaries, and their values as TOML."""

from __future__ import annotations

import hashlib
import json
import math
import os
import pathlib
import re
import tempfile
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

import tomli_w

from .program import FileError

Scenario = Mapping[str, Any]
"""Tables, lists, texts, numbers and truth values, as `docs/scenario.md` has them."""


def read_scenario(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The scenario file as a dictionary, as it stands, without defaults (`Result.scenario` has them)."""
    if not os.path.isfile(path):
        raise FileError(f"{path}: is no file, or a pipe or device: name a scenario")
    with open(path, "rb") as file:
        return tomllib.load(file)


def write_scenario(scenario: Scenario, path: str | os.PathLike[str], *, force: bool = False) -> pathlib.Path:
    """Writes a scenario; files that it names are sought in the folder of `path`.

    A file that holds the same scenario stays as it is, one that this function wrote is replaced. Raises `FileError` for any other unless
    `force` is set.
    """
    path = pathlib.Path(path)
    values = plain(scenario)
    text = tomli_w.dumps(values)
    if not force and os.path.lexists(path):
        there = read_text(path)
        if _is_same(there, values):
            return path
        if not _is_ours(there):
            raise FileError(f"{path}: exists and holds another scenario, which is not replaced: choose another name")
    write_whole(path, f"{MARK}{_digest(text)}\n{text}".encode())
    return path


MARK = "# Written by the Python package fbimpact, which replaces it unless it is changed: "


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _is_ours(text: str) -> bool:
    """Whether `write_scenario` wrote the text, and nobody has changed it since."""
    first, _, rest = text.partition("\n")
    return first == MARK + _digest(rest)


def _is_same(text: str, values: Any) -> bool:
    try:
        return bool(tomllib.loads(text) == values)
    except tomllib.TOMLDecodeError:
        return False


def read_text(path: pathlib.Path) -> str:
    """The text of a file, in which anything may stand. Raises `FileError` for what is none."""
    if not path.is_file():
        raise FileError(f"{path}: is a folder, pipe or device, or a link to nothing: name a file")
    return path.read_text(encoding="utf-8", errors="replace")


def write_whole(path: pathlib.Path, data: bytes) -> None:
    """Writes a file in whole or not at all: aside first, under a name that nobody else has."""
    number, name = tempfile.mkstemp(dir=path.parent, prefix=f"{path.name}.", suffix=".tmp")
    try:
        with open(number, "wb") as file:
            file.write(data)
            umask = os.umask(0)
            os.umask(umask)
            os.chmod(name, 0o666 & ~umask)
        os.replace(name, path)
    except BaseException:
        pathlib.Path(name).unlink(missing_ok=True)
        raise


def override(scenario: Scenario, changes: Mapping[str, Any]) -> dict[str, Any]:
    """A copy of the scenario in which keys such as `bodies.ball.velocity` or `bodies.ball.position[2]` have other values.

    Tables that a key leads through are made if they are not there, as `--set` does.
    """
    copy: dict[str, Any] = plain(scenario)
    for key, value in changes.items():
        steps = path_of(key)
        place: Any = copy
        for step, following in zip(steps, steps[1:]):
            if isinstance(step, str) and isinstance(place, dict) and step not in place and isinstance(following, str):
                place[step] = {}
            place = _inside(place, step, key)
        last = steps[-1]
        if isinstance(last, int) or not isinstance(place, dict):
            _inside(place, last, key)  # fails if it is not there
        place[last] = plain(value)
    return copy


def path_of(key: str) -> list[str | int]:
    """Names and indices of a key: `bodies.ball.discretisation.refine[0].width`."""
    steps: list[str | int] = []
    for part in key.split("."):
        match = re.fullmatch(r"([A-Za-z0-9_-]+)((?:\[\d+\])*)", part)
        if match is None:
            raise ValueError(f"{key!r} is no key: names with dots between, [0] for the first of a list")
        steps.append(match[1])
        steps.extend(int(i) for i in re.findall(r"\d+", match[2]))
    return steps


def _inside(place: Any, step: str | int, key: str) -> Any:
    try:
        return place[step]
    except (KeyError, IndexError, TypeError):
        raise KeyError(f"{key}: there is no {step!r}") from None


def plain(value: Any) -> Any:
    """The value in types of Python alone: arrays and scalars of numpy become lists and numbers."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [plain(v) for v in value]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    return value


def to_toml(value: Any) -> str:
    """A value as `--set` takes it."""
    value = plain(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{value} is no value of a scenario")
        return repr(value)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, list):
        return "[" + ", ".join(map(to_toml, value)) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(k)} = {to_toml(v)}" for k, v in value.items()) + " }"
    raise TypeError(f"{value!r} is no value of a scenario")


def set_arguments(changes: Mapping[str, Any]) -> list[str]:
    """`--set` for each change."""
    return [word for line in set_lines(changes) for word in ("--set", line)]


def set_lines(changes: Mapping[str, Any]) -> list[str]:
    """KEY=VALUE for each change."""
    return [f"{key}={to_toml(value)}" for key, value in changes.items()]
