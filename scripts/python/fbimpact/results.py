"""Results as xarray datasets. Names, dimensions and units are those of docs/results.md."""

from __future__ import annotations

import json
import os
import pathlib
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import h5py
import numpy as np
import xarray as xr

from .guards import open_file, state
from .program import FileError, call

VERSION = 2
"""The latest version of results that is read."""
TABLES = ("phases", "impacts", "events", "tries", "transfers")


@dataclass(frozen=True)
class Metric:
    """Value of an expression: a number, a list or rows of numbers."""

    value: Any
    """None for what is no number."""
    unit: str | None
    """None where it does not follow."""
    components: list[str] | None = None

    def __float__(self) -> float:
        return float("nan") if self.value is None else float(self.value)


class Result:
    """A result file. Nothing of it is held open; each access reads what it names."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = pathlib.Path(path)
        self._places: dict[str, tuple[object, dict[str, int]]] = {}
        with self._open() as file:
            attributes = dict(file.attrs)
            has_scenario = isinstance(file.get("scenario"), h5py.Dataset)
        version = attributes.get("format_version", 1)
        if not np.isscalar(version) or version not in range(VERSION + 1):
            raise FileError(f"{self.path}: has format version {version}, this package reads up to {VERSION}: install the package of its program")
        if not has_scenario or "status" not in attributes:
            raise FileError(f"{self.path}: has no {'status' if has_scenario else 'scenario'}, it is damaged or no whole result: run it again")
        self.attributes = {name: _plain(value) for name, value in attributes.items()}

    def __repr__(self) -> str:
        return f"<fbimpact result {self.path}, {self.status}>"

    @property
    def status(self) -> str:
        """`complete`, `interrupted`, `failed` or `running`."""
        return str(self.attributes["status"])

    @property
    def message(self) -> str:
        """Why the run is not complete; empty otherwise."""
        return str(self.attributes.get("message", ""))

    @property
    def title(self) -> str:
        """Title of the scenario."""
        return str(self.attributes.get("title", ""))

    @property
    def scenario(self) -> dict[str, Any]:
        """The scenario of the run, with changes and defaults filled in."""
        with self._open() as file:
            return tomllib.loads(_text(file["scenario"][()]))

    @property
    def warnings(self) -> list[str]:
        """Warnings of the run."""
        with self._open() as file:
            return [_text(text) for text in file["warnings"][:]] if "warnings" in file else []

    @property
    def time(self) -> xr.DataArray:
        """Stored instants [s]."""
        return self.dataset("/")["time"]

    def dataset(self, path: str) -> xr.Dataset:
        """All datasets of one group, such as `contacts/impact`, with coordinates, units (`units`) and descriptions (`long_name`).

        In a result of many bodies, whose motion is in `arrays/bodies`, `bodies/NAME` has that of one.
        """
        kind, _, member = path.strip("/").partition("/")
        with self._open() as file:
            index = self._members(file, kind).get(member)
            if index is None and (path not in file or not isinstance(file[path], h5py.Group)):
                raise KeyError(f"{self.path}: there is no group {path!r}")
            variables: dict[str, xr.Variable] = {}
            coordinates: dict[str, xr.Variable] = {}
            for name, item in file[f"arrays/{kind}"].items() if index is not None else ():
                if not _is_scale(item):
                    variables[name] = _variable(item, coordinates, index)
            group = file[path] if path in file else {}
            for name, item in group.items():
                if isinstance(item, h5py.Dataset) and item.dtype.names is None and item.ndim > 0:
                    if not _is_scale(item):
                        variables[name] = _variable(item, coordinates)
                elif isinstance(item, h5py.Dataset) and item.ndim == 0 and item.dtype.kind == "f":
                    variables[name] = xr.Variable((), item[()], _attributes(item))
            attributes = {name: _plain(value) for name, value in getattr(group, "attrs", {}).items()}
        return xr.Dataset(variables, coordinates, attributes)

    def __getitem__(self, path: str) -> xr.Dataset | xr.DataArray:
        """A group or one dataset of it: `result["contacts/impact"]`, `result["contacts/impact/normal_force"]`."""
        path = path.strip("/")
        with self._open() as file:
            kind, _, member = path.partition("/")
            is_group = member in self._members(file, kind) or path in file and isinstance(file[path], h5py.Group)
        if is_group:
            return self.dataset(path)
        if path in TABLES:
            return self.table(path)
        group, _, name = path.rpartition("/")
        dataset = self.dataset(group or "/")
        if name not in dataset:
            raise KeyError(f"{self.path}: there is no {path!r}")
        return dataset[name]

    @property
    def bodies(self) -> Mapping[str, xr.Dataset]:
        """Motion of each body over time."""
        return Groups(self, "bodies")

    @property
    def contacts(self) -> Mapping[str, xr.Dataset]:
        """Forces of each contact over time."""
        return Groups(self, "contacts")

    @property
    def joints(self) -> Mapping[str, xr.Dataset]:
        """Coordinates and reactions of each joint over time."""
        return Groups(self, "joints")

    @property
    def gears(self) -> Mapping[str, xr.Dataset]:
        """Force of each gear over time."""
        return Groups(self, "gears")

    @property
    def points(self) -> Mapping[str, xr.Dataset]:
        """Motion of each observed point over time, and its stress and strain where the scenario asks for them."""
        return Groups(self, "points")

    @property
    def stress(self) -> Mapping[str, xr.Dataset]:
        """Stress along each line that the scenario asks for."""
        return Groups(self, "stress")

    @property
    def energies(self) -> xr.Dataset:
        """Energy ledger over time [J]."""
        return self.dataset("energies")

    @property
    def momentum(self) -> xr.Dataset:
        """Momenta over time."""
        return self.dataset("momentum")

    @property
    def phases(self) -> xr.Dataset:
        """Phases of the run."""
        return self.table("phases")

    @property
    def impacts(self) -> xr.Dataset:
        """Impacts in the order of their ends."""
        return self.table("impacts")

    @property
    def events(self) -> xr.Dataset:
        """What contacts do: touch, release, stick, slip, rest."""
        return self.table("events")

    @property
    def tries(self) -> xr.Dataset:
        """Trials of every impact."""
        return self.table("tries")

    @property
    def transfers(self) -> xr.Dataset:
        """Changes of models."""
        return self.table("transfers")

    def table(self, name: str) -> xr.Dataset:
        """A table, its rows along the dimension of its name, numbered from 1; rows of two or three numbers have a dimension of their own."""
        with self._open() as file:
            if name not in file or file[name].dtype.names is None:
                raise KeyError(f"{self.path}: there is no table {name!r}")
            rows, text = file[name][:], _text(file[name].attrs.get("unit", ""))
        units = dict(part.split(": ", 1) for part in text.split(", ") if ": " in part)
        variables: dict[str, xr.Variable] = {}
        for column in rows.dtype.names:
            values = rows[column]
            if values.dtype.kind == "O":
                values = np.array([_text(v) for v in values], dtype=str)
            dimensions = (name,) if values.ndim == 1 else (name, f"{column}_component")
            variables[column] = xr.Variable(dimensions, values, {"units": units.get(column, "–")})
        for column, variable in variables.items():
            if (band := variables.get(f"{column}_uncertainty")) is not None:
                variable.attrs["uncertainty"] = band.values
        return xr.Dataset(variables, {name: np.arange(1, len(rows) + 1)})

    def pressure(self, contact: str, time: float | str = "peak") -> xr.Dataset:
        """Pressure at the loaded points of a contact at the stored instant nearest to `time` [s], or at the largest stored force.

        `position` is undeformed, in the frame of the contact body; pressure times area, summed, is the normal force.
        """
        series = self.dataset(f"contacts/{contact}")
        if time == "peak":
            at = int(series["normal_force"].values.argmax())
        elif isinstance(time, str):
            raise ValueError(f"time={time!r}: must be a number of seconds, or 'peak'")
        else:
            at = int(np.abs(series["time"].values - time).argmin())
        with self._open() as file:
            group = file.get(f"pressure/{contact}")
            if group is None:
                raise KeyError(f"{self.path}: contact {contact!r} has no stored pressures")
            ends = np.cumsum(series["pressure_points"].values.astype(int))
            part = slice(int(ends[at - 1]) if at > 0 else 0, int(ends[at]))
            which = group["point"][part]
            position = xr.Variable(("point", "xyz"), group["position"][:][which], _attributes(group["position"]))
            area = xr.Variable("point", group["area"][:][which], _attributes(group["area"]))
            pressure = xr.Variable("point", group["pressure"][part], _attributes(group["pressure"]))
        instant = xr.Variable((), float(series["time"].values[at]), {"units": "s"})
        coordinates = {"time": instant, "xyz": ["x", "y", "z"]}
        return xr.Dataset({"position": position, "area": area, "pressure": pressure}, coordinates)

    def metric(self, expression: str) -> Metric:
        """Value of an expression (docs/expressions.md), such as `max(contacts.impact.normal_force)`."""
        return self.metrics({"value": expression})["value"]

    def metrics(self, expressions: Mapping[str, str]) -> dict[str, Metric]:
        """Values of expressions by name."""
        arguments = [f"{name}={expression}" for name, expression in expressions.items()]
        found = json.loads(call(["metric", self.path, *arguments]))
        return {n: Metric(m.get("value"), m.get("unit"), m.get("components")) for n, m in found.items()}

    def probe(
        self,
        body: str,
        *,
        points: Sequence[Sequence[float]] = (),
        markers: Sequence[str] = (),
        start: float | None = None,
        end: float | None = None,
    ) -> list[xr.Dataset]:
        """Motion, stress and strain over time of points of the undeformed body or of markers, a dataset each (docs/histories.md).

        Models are built again for it, which takes about as long as the start of the run.
        """
        arguments: list[str] = ["--json", "--body", body]
        for point in points:
            arguments += ["--point", ",".join(repr(float(x)) for x in point)]
        for marker in markers:
            arguments += ["--marker", marker]
        for option, value in (("--from", start), ("--to", end)):
            arguments += [option, repr(float(value))] if value is not None else []
        return _probed(json.loads(call(["probe", "-q", self.path, *arguments])))

    def _open(self) -> Any:
        return open_file(self.path)

    def _members(self, file: Any, kind: str) -> dict[str, int]:
        """Places of the members of a group in the datasets that they share; none where each has a group."""
        now = state(self.path)
        known = self._places.get(kind)
        if known is None or known[0] != now:
            names = file.get(f"arrays/{kind}/name") if kind else None
            known = now, {} if names is None else {_text(name): index for index, name in enumerate(names[()])}
            self._places[kind] = known
        return known[1]


class Groups(Mapping[str, xr.Dataset]):
    """Groups under one path by name; each access reads one."""

    def __init__(self, result: Result, path: str) -> None:
        self._result, self._path = result, path

    def __getitem__(self, name: str) -> xr.Dataset:
        try:
            return self._result.dataset(f"{self._path}/{name}")
        except KeyError:
            raise KeyError(f"{name!r}: {self._path} are {', '.join(self) or 'none'}") from None

    def __iter__(self) -> Iterator[str]:
        with self._result._open() as file:
            return iter(list(dict.fromkeys([*self._result._members(file, self._path), *file.get(self._path, ())])))

    def __len__(self) -> int:
        return len(list(iter(self)))

    def __repr__(self) -> str:
        return f"<{self._path}: {', '.join(self)}>"


def open_result(path: str | os.PathLike[str]) -> Result:
    """Opens a result, also one of a run that goes on (`NAME.h5.part`)."""
    return Result(path)


def _variable(item: Any, coordinates: dict[str, xr.Variable], member: int | None = None) -> xr.Variable:
    """A dataset with its dimensions, or the part of one member of it; their scales are added to `coordinates`."""
    name = item.name.rpartition("/")[2]
    dimensions = []
    for k, dimension in enumerate(item.dims):
        if k == 1 and member is not None:
            continue
        scale = dimension[0] if len(dimension) > 0 else None
        label = dimension.label or f"{name}_{k}"
        # Coordinates and velocities of a joint differ in number where it has a quaternion.
        if scale is not None and scale.name.endswith("/velocities_names"):
            label = "rate"
        dimensions.append(label)
        if scale is not None and label not in coordinates:
            coordinates[label] = xr.Variable((label,), _values(scale), _attributes(scale))
    values = _values(item) if member is None else item[:, member]
    return xr.Variable(dimensions, values, _attributes(item))


def _is_scale(item: Any) -> bool:
    return _text(item.attrs.get("CLASS", "")) == "DIMENSION_SCALE"


def _values(item: Any) -> Any:
    values = item[()]
    return np.array([_text(v) for v in values], dtype=str) if item.dtype.kind == "O" else values


def _attributes(item: Any) -> dict[str, Any]:
    attributes = {}
    for ours, theirs in (("units", "unit"), ("long_name", "description"), ("time", "time")):
        if theirs in item.attrs:
            attributes[ours] = _plain(item.attrs[theirs])
    return attributes


def _probed(found: Any) -> list[xr.Dataset]:
    units, tensor = found["units"], found.get("tensor_components", [])
    datasets = []
    for point in found["points"]:
        coordinates: dict[str, Any] = {"time": xr.Variable("time", found["time"], {"units": "s"})}
        variables: dict[str, xr.Variable] = {}
        for name, values in point.items():
            if name in ("name", "place") or values is None:
                continue
            rows, unit = _numbers(values), {"units": units.get(name, "–")}
            if rows.ndim == 1:
                variables[name] = xr.Variable("time", rows, unit)
            elif rows.shape[1] == 3:
                coordinates["xyz"] = ["x", "y", "z"]
                variables[name] = xr.Variable(("time", "xyz"), rows, unit)
            else:
                # Components that the model does not have are called "-".
                there = [k for k, component in enumerate(tensor) if component != "-"]
                coordinates["component"] = [tensor[k] for k in there]
                variables[name] = xr.Variable(("time", "component"), rows[:, there], unit)
        datasets.append(xr.Dataset(variables, coordinates, {"name": point["name"], "place": point["place"]}))
    return datasets


def _numbers(values: Any) -> Any:
    return np.array(values, dtype=float)  # None becomes NaN


def _text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


def _plain(value: Any) -> Any:
    if isinstance(value, bytes):
        return value.decode()
    return value.item() if hasattr(value, "item") and getattr(value, "ndim", 0) == 0 else value
