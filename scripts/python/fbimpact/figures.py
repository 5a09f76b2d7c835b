"""Figures in notebooks. Needs matplotlib; `fbimpact plot` draws without it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from .results import Result


def _axes(axes: Any) -> Any:
    if axes is not None:
        return axes
    import matplotlib.pyplot as plt

    return plt.subplots(layout="constrained")[1]


def impact(results: Result | Sequence[Result], number: int = 1, *, axes: Any = None) -> Any:
    """Normal force of the n-th impact, from 1, over the time since its first contact, of one result or several. Returns the axes."""
    axes = _axes(axes)
    for result in [results] if isinstance(results, Result) else results:
        table = result.impacts
        if not 1 <= number <= table.sizes["impacts"]:
            raise IndexError(f"{result.path}: there is no impact {number}, it has {table.sizes['impacts']}")
        row = table.isel(impacts=number - 1)
        force = result.contacts[str(row["contact"].item())]["normal_force"]
        start, end = float(row["start"]), float(row["end"])
        margin = 0.1 * (end - start)
        part = force.where((force["time"] >= start - margin) & (force["time"] <= end + margin), drop=True)
        axes.plot(1e6 * (part["time"] - start), part, label=result.path.stem)
    axes.set_xlabel("time since first contact [µs]")
    axes.set_ylabel("normal force [N]")
    axes.legend()
    return axes


def ledger(result: Result, *, axes: Any = None) -> Any:
    """Energies that are not zero over time. Returns the axes."""
    axes = _axes(axes)
    for name, energy in result.energies.data_vars.items():
        if np.any(energy.values != 0.0):
            axes.plot(energy["time"], energy, label=str(name).replace("_", " "))
    axes.set_xlabel("time [s]")
    axes.set_ylabel("energy [J]")
    axes.legend()
    return axes


def spectrum(series: xr.DataArray, *, axes: Any = None) -> Any:
    """Amplitude spectrum of a series over time, as `amplitudes` has it. Returns the axes."""
    axes = _axes(axes)
    found = amplitudes(series)
    axes.loglog(found["frequency"][1:], found[1:])
    axes.set_xlabel("frequency [Hz]")
    axes.set_ylabel(f"{series.name} [{series.attrs.get('units', '–')}]")
    return axes


def amplitudes(series: xr.DataArray) -> xr.DataArray:
    """Amplitudes of a series over time by frequency: Hann window over the whole series, less its mean, on even instants.

    Stored instants are not even: the series is interpolated linearly to as many as their median distance asks for, so that frequencies end at
    half of its inverse. A harmonic at one of the frequencies has its own amplitude.
    """
    time, values = series["time"].values, series.values
    distinct = np.concatenate([[True], np.diff(time) > 0.0])
    time, values = time[distinct], values[distinct]
    if len(time) < 4:
        raise ValueError(f"{series.name}: {len(time)} instants have no spectrum, at least four are needed")
    step = float(np.median(np.diff(time)))
    n = round((time[-1] - time[0]) / step) + 1
    even = np.linspace(time[0], time[-1], n)
    at = np.interp(even, time, values)
    window = np.hanning(n + 1)[:-1]
    found = 2.0 * np.abs(np.fft.rfft((at - at.mean()) * window)) / window.sum()
    frequency = np.fft.rfftfreq(n, even[1] - even[0])
    return xr.DataArray(found, {"frequency": ("frequency", frequency, {"units": "Hz"})}, ("frequency",), series.name, series.attrs)


def pressure_map(result: Result, contact: str, time: float | str = "peak", *, axes: Any = None) -> Any:
    """Contact pressure over the undeformed surface at an instant: over the radius in axisymmetric models, in a map of two directions otherwise. Returns the axes."""
    axes = _axes(axes)
    found = result.pressure(contact, time)
    if found.sizes["point"] == 0:
        raise ValueError(f"{result.path}: contact {contact!r} is open at {time}")
    position, pressure = found["position"].values, 1e-6 * found["pressure"].values
    extent = np.ptp(position, axis=0)
    # Directions with the largest extent; flat models have one.
    first, second = sorted(np.argsort(extent)[-2:])
    names = found["xyz"].values
    if extent[np.argsort(extent)[-2]] <= 1e-2 * extent.max():
        along = int(np.argmax(extent))
        order = np.argsort(position[:, along])
        axes.plot(1e3 * position[order, along], pressure[order], marker=".")
        axes.set_xlabel(f"{names[along]} [mm]")
        axes.set_ylabel("contact pressure [MPa]")
        return axes
    drawn = axes.scatter(1e3 * position[:, first], 1e3 * position[:, second], c=pressure, cmap="viridis")
    axes.figure.colorbar(drawn, ax=axes, label="contact pressure [MPa]")
    axes.set_aspect("equal")
    axes.set_xlabel(f"{names[first]} [mm]")
    axes.set_ylabel(f"{names[second]} [mm]")
    return axes
