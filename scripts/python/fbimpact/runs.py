"""Single runs."""

from __future__ import annotations

import os
import pathlib
import tempfile
from collections.abc import Mapping
from typing import Any

from .program import call
from .results import Result, open_result
from .scenario import Scenario, set_arguments, write_scenario


def check(scenario: str | os.PathLike[str] | Scenario, changes: Mapping[str, Any] | None = None) -> None:
    """Checks a scenario, given as a file or a dictionary; raises `ScenarioError` with all its faults, `ModelError` for what a run refuses."""
    with tempfile.TemporaryDirectory() as folder:
        path = _file_of(scenario, pathlib.Path(folder) / "scenario.toml")
        call(["check", "-q", path, *set_arguments(changes or {})])


def run(
    scenario: str | os.PathLike[str] | Scenario,
    changes: Mapping[str, Any] | None = None,
    *,
    output: str | os.PathLike[str] | None = None,
    threads: int = 0,
    log: bool = False,
) -> Result:
    """Runs a scenario and opens its result.

    `scenario` is a file, or a dictionary, which is written beside the result under its name with `.toml` (`write_scenario`: no file of
    somebody else is replaced). `changes` are keys with
    values, as `--set`. `output` is the result, by default the scenario's name with `.h5` in the working directory; an earlier result
    is replaced by a complete one alone. `threads` is 0 for all cores. With `log` the program's messages go to standard error.

    Raises `ScenarioError`, `ModelError`, or `RunFailed`; what was computed until then is in the file `output`.
    """
    if isinstance(scenario, Mapping):
        output = pathlib.Path(output if output is not None else "scenario.h5")
    else:
        output = pathlib.Path(output if output is not None else pathlib.Path(scenario).with_suffix(".h5").name)
    path = _file_of(scenario, output.with_suffix(".toml"))
    level = [] if log else ["-q"]
    call(["run", *level, path, "-o", output, "--threads", str(threads), *set_arguments(changes or {})], log=log)
    return open_result(output)


def _file_of(scenario: str | os.PathLike[str] | Scenario, path: pathlib.Path) -> pathlib.Path:
    return write_scenario(scenario, path) if isinstance(scenario, Mapping) else pathlib.Path(scenario)
