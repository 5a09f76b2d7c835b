"""Many runs of a scenario, several at a time, in a folder as `scripts/sweep.sh` leaves it: each of the two goes on with what the other began."""

from __future__ import annotations

import hashlib
import os
import pathlib
import signal
import subprocess
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import IO, Any

import h5py
import numpy as np
import xarray as xr

from .program import FileError, call, find_program
from .results import Metric, Result, open_result
from .sampling import full_factorial
from .scenario import Scenario, plain, set_lines, write_scenario


@dataclass(frozen=True)
class SweepRun:
    """One run of a sweep."""

    name: str
    """Made from its values."""
    values: Mapping[str, Any]
    """Keys with their values."""
    folder: pathlib.Path

    @property
    def path(self) -> pathlib.Path:
        """Its result."""
        return self.folder / f"{self.name}.h5"

    @property
    def exit_code(self) -> int | None:
        """How it ended; None if it has not."""
        try:
            return int((self.folder / f"{self.name}.exit").read_text())
        except (FileNotFoundError, ValueError):
            return None

    @property
    def is_complete(self) -> bool:
        """Whether its result is there and whole."""
        return self.exit_code == 0 and self.path.is_file()

    @property
    def log(self) -> str:
        """What it said."""
        return (self.folder / f"{self.name}.log").read_text(errors="replace")

    def result(self) -> Result:
        """Opens its result."""
        return open_result(self.path)


@dataclass(frozen=True)
class Sweep:
    """A sweep that has been made. Failed runs are among its runs."""

    folder: pathlib.Path
    runs: list[SweepRun]

    @property
    def failed(self) -> list[SweepRun]:
        """Runs without a complete result."""
        return [run for run in self.runs if not run.is_complete]

    def table(self, columns: Mapping[str, str] | None = None) -> xr.Dataset:
        """One row a run along the dimension `run`, as `fbimpact collect` has it (docs/sweeps.md), with a column for each expression of `columns`.

        Rows are in the order of `runs`. The same is in `table.csv` and `table.h5` of the folder.
        """
        expressions = [word for name, text in (columns or {}).items() for word in ("--column", f"{name}={text}")]
        for ending in ("csv", "h5"):
            call(["collect", "-q", self.folder, "-o", self.folder / f"table.{ending}", *expressions])
        with h5py.File(self.folder / "table.h5", "r") as file:
            group = file["runs"]
            rows = {pathlib.Path(_text(path)).name: i for i, path in enumerate(group["run"][:])}
            order = [rows[run.name] for run in self.runs if run.name in rows]
            variables = {name: _column(item, order) for name, item in group.items() if len(item) == len(rows)}
        return xr.Dataset(variables)

    def grid(self, columns: Mapping[str, str] | None = None) -> xr.Dataset:
        """The numbers of `table` over the values that were swept: a dimension a key, numeric where its values are numbers.

        Of vectors in which one component differs, that component is the axis, `bodies.ball.velocity[2]`. What was not run, or failed, is NaN.

        Raises `ValueError` if vectors differ in several components, or if two runs have the same place.
        """
        table = self.table(columns)
        levels, places = _places(self.runs)
        shape = tuple(len(values) for values in levels.values())
        variables: dict[str, xr.Variable] = {}
        for name, column in table.variables.items():
            if column.dtype.kind not in "fiu" or str(name).startswith("set."):
                continue
            values = np.full(shape, np.nan)
            for place, value in zip(places, column.values):
                values[place] = value
            variables[str(name)] = xr.Variable(tuple(levels), values, column.attrs)
        return xr.Dataset(variables, {name: np.array(values) for name, values in levels.items()})

    def impacts(self) -> xr.Dataset:
        """The numbers of the impacts of all runs over the values that were swept, and along `impacts` in the order of their ends, from 1.

        Axes are those of `grid`. Of a run with fewer impacts, or without a complete result, the others are NaN.

        Raises `ValueError` as `grid`.
        """
        levels, places = _places(self.runs)
        tables = [run.result().impacts if run.is_complete else None for run in self.runs]
        most = max((table.sizes["impacts"] for table in tables if table is not None), default=0)
        shape = (*(len(values) for values in levels.values()), most)
        variables: dict[str, xr.Variable] = {}
        for place, table in zip(places, tables):
            for name, column in table.data_vars.items() if table is not None else ():
                if column.dtype.kind in "fiu" and column.dims == ("impacts",):
                    empty = xr.Variable((*levels, "impacts"), np.full(shape, np.nan), column.attrs)
                    variables.setdefault(str(name), empty)[(*place, slice(column.size))] = column.values
        coordinates = {name: np.array(values) for name, values in levels.items()}
        return xr.Dataset(variables, {**coordinates, "impacts": np.arange(1, most + 1)})

    def metric(self, expression: str) -> list[Metric | None]:
        """Value of an expression for every run; None for runs without a complete result."""
        return [run.result().metric(expression) if run.is_complete else None for run in self.runs]


def sweep(
    scenario: str | os.PathLike[str] | Scenario,
    values: Mapping[str, Iterable[Any]] | Sequence[Mapping[str, Any]],
    folder: str | os.PathLike[str],
    *,
    jobs: int = 0,
    threads: int = 1,
    progress: Callable[[SweepRun, int, int], None] | None = None,
) -> Sweep:
    """Runs a scenario with changed values.

    `values` are lists of values by key, of which all combinations are run, or the combinations themselves, such as those of
    `latin_hypercube`. `jobs` runs go on at a time, 0: as many as there are cores, each with `threads` threads. Runs that are complete in
    `folder` are not made again unless the scenario, a file that it names or the program has changed, interrupted and killed ones go on, failed ones are tried again. `progress` is called after each run
    with it, the number of runs that have ended and the number of all.

    A failed run stops no other: see `Sweep.failed`. Ctrl-C stops the runs that go on as it stops a single one; the next call goes on.

    Raises `ValueError` in a folder that was begun with another scenario file.
    """
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    path = write_scenario(scenario, folder / "scenario.toml") if isinstance(scenario, Mapping) else pathlib.Path(scenario)
    rows = full_factorial(values) if isinstance(values, Mapping) else [dict(row) for row in values]
    _begin(folder, path)
    runs = list({run.name: run for run in (_planned(folder, row) for row in rows)}.values())
    (folder / "plan").write_text("".join(f"{run.name}\n" for run in runs))
    work = _Work(path, threads)
    ended = 0
    lock = threading.Lock()

    def one(run: SweepRun) -> None:
        nonlocal ended
        work.do(run)
        with lock:
            ended += 1
            if progress is not None and not work.is_stopped:
                progress(run, ended, len(runs))

    with ThreadPoolExecutor(max_workers=jobs or os.cpu_count() or 1) as pool:
        futures = [pool.submit(one, run) for run in runs]
        try:
            for future in futures:
                future.result()
        except BaseException:
            work.stop()
            raise
    return Sweep(folder, runs)


def _begin(folder: pathlib.Path, scenario: pathlib.Path) -> None:
    """Notes which scenario the folder is of: files of another one, or of no sweep, are not replaced."""
    path = os.fsencode(os.path.realpath(scenario))
    note = folder / "scenario.path"
    if note.exists():
        if note.read_bytes().rstrip(b"\n") != path.rstrip(b"\n"):
            raise ValueError(f"{folder} was begun with {os.fsdecode(note.read_bytes()).strip()}, use another folder")
    elif (folder / "plan").exists() and not (folder / "scenario.sha256").exists():
        raise FileError(f"{folder / 'plan'}: is of no sweep, use another folder")
    note.write_bytes(path + b"\n")


def _planned(folder: pathlib.Path, values: Mapping[str, Any]) -> SweepRun:
    block = "".join(f"{line}\n" for line in set_lines(values))
    run = SweepRun(f"run-{hashlib.sha256(block.encode()).hexdigest()[:12]}", dict(values), folder)
    (folder / f"{run.name}.set").write_text(block)
    return run


class _Work:
    """Runs on their way."""

    def __init__(self, scenario: pathlib.Path, threads: int) -> None:
        self.program = find_program()
        self.scenario = scenario
        self.threads = ["--threads", str(threads)]
        self.is_stopped = False
        self._running: set[subprocess.Popen[bytes]] = set()
        self._lock = threading.Lock()

    def do(self, run: SweepRun) -> None:
        """Does a run, unless it is done; its exit code goes to its file."""
        stem = run.folder / run.name
        ended = stem.with_name(f"{run.name}.exit")
        changes = [word for line in set_lines(run.values) for word in ("--set", line)]
        # Killed runs go on; all is run anew if the scenario, a file that it names or the program has changed.
        command = [self.program, "run", "--update", "--force", "-o", str(run.path.absolute()), *changes]
        scenario = ["--", str(self.scenario.absolute())]
        if self.is_stopped or (run.is_complete and self._call([*command, "--dry-run", *scenario], subprocess.DEVNULL) == 0):
            return
        ended.unlink(missing_ok=True)
        with open(stem.with_name(f"{run.name}.log"), "wb") as log:
            code = self._call([*command, *self.threads, *scenario], log)
        new = stem.with_name(f"{run.name}.exit.new")
        new.write_text(f"{code}\n")
        new.replace(ended)

    def _call(self, command: list[str], log: int | IO[bytes]) -> int:
        with self._lock:
            if self.is_stopped:
                return 130
            # A group of its own: Ctrl-C reaches this process alone, which stops the runs once.
            process = subprocess.Popen(command, stdout=log, stderr=log, stdin=subprocess.DEVNULL, start_new_session=True)
            self._running.add(process)
        try:
            return process.wait()
        finally:
            with self._lock:
                self._running.discard(process)

    def stop(self) -> None:
        """Lets runs store what they have and end; begins no others."""
        with self._lock:
            self.is_stopped = True
            for process in self._running:
                process.send_signal(signal.SIGTERM)


def _keys(runs: Sequence[SweepRun]) -> list[str]:
    """Keys that any run sets, in the order in which they were given."""
    return list(dict.fromkeys(key for run in runs for key in run.values))


def _places(runs: Sequence[SweepRun]) -> tuple[dict[str, list[Any]], list[tuple[int, ...]]]:
    """The axes of a sweep with their values in order, and where each run stands along them."""
    axes = {name: values for key in _keys(runs) for name, values in [_axis(runs, key)] if len(set(values)) > 1}
    levels = {name: sorted(set(values)) for name, values in axes.items()}
    places = [tuple(levels[name].index(axes[name][i]) for name in axes) for i in range(len(runs))]
    if len(set(places)) < len(places):
        raise ValueError("two runs have the same values of all keys that differ")
    return levels, places


def _axis(runs: Sequence[SweepRun], key: str) -> tuple[str, list[Any]]:
    """Name and value of every run along the axis of a key."""
    given = [plain(run.values.get(key)) for run in runs]
    if not all(isinstance(value, list) for value in given):
        return key, [value if isinstance(value, (int, float)) else str(value) for value in given]
    differing = [i for i, values in enumerate(zip(*given)) if len(set(map(str, values))) > 1]
    if len({len(value) for value in given}) > 1 or len(differing) > 1:
        raise ValueError(f"{key}: vectors differ in several components, they have no place along one axis")
    at = differing[0] if differing else 0
    return f"{key}[{at}]", [value[at] for value in given]


def _column(item: Any, order: list[int]) -> xr.Variable:
    values = item[:][order]
    if values.dtype.kind == "O":
        values = np.array([_text(v) for v in values], dtype=str)
    unit = _text(item.attrs.get("unit", "–"))
    return xr.Variable("run", values, {"units": unit})


def _text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)
