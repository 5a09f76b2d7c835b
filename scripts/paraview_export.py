"""Shows an export of `fbimpact export` in ParaView: bodies by von Mises stress in one scale for all instants, contact pressure as points,
joints, loads and names of a scenario.

    FBIMPACT_EXPORT=PICTURES.pvd|SCENARIO.vtm paraview --script=scripts/paraview_export.py
    pvpython scripts/paraview_export.py PICTURES.pvd|SCENARIO.vtm --picture OUT.png [--time T]

Without `--time` a picture is of the instant of the largest von Mises stress. Needs ParaView 5.10; rational cells (exports without
`--plain`) are drawn right from 5.12 on.
"""

import argparse
import os
import pathlib
import sys
import xml.etree.ElementTree as ElementTree

from paraview import simple

STRESS, PRESSURE = "von Mises stress [Pa]", "contact pressure [Pa]"
BODY = [0.78, 0.80, 0.84]  # bodies without stress
# Names of blocks of a scenario, with colour and width of their lines and points.
MARKS = {"joints": ([0.84, 0.37, 0.0], 4), "contacts": ([0.0, 0.45, 0.70], 3), "frames": ([0.4, 0.4, 0.4], 2), "markers": ([0.0, 0.62, 0.45], 3)}


def parts_of(path):
    """Names of the parts of a series or of blocks, with the files of each and their times."""
    root = ElementTree.parse(path).getroot()
    parts = {}
    if path.suffix == ".vtm":
        for block in root.iter("Block"):
            for entry in block.iter("DataSet"):
                parts[f"{block.get('name')}/{entry.get('name')}"] = [(0.0, path.parent / entry.get("file"))]
        return parts
    for entry in root.iter("DataSet"):
        parts.setdefault(entry.get("name"), []).append((float(entry.get("timestep")), path.parent / entry.get("file")))
    return parts


def point_range(source, name, component=0):
    """Range of a field of points at the present instant; none if it is not there, or on no point."""
    field = source.GetPointDataInformation().GetArray(name)
    if field is None or source.GetDataInformation().GetNumberOfPoints() == 0:
        return None
    low, high = field.GetRange(component)
    return (low, high) if low <= high else None


def largest(sources, times, name):
    """Largest value of a field over all sources and instants, and when."""
    best = (0.0, times[0])
    for time in times:
        for source in sources:
            source.UpdatePipeline(time)
            found = point_range(source, name)
            if found is not None and found[1] > best[0]:
                best = (found[1], time)
    return best


def coloured(shown, name, high, title, preset):
    """Colours of a field from zero to `high`."""
    simple.ColorBy(shown, ("POINTS", name))
    table = simple.GetColorTransferFunction(name)
    table.ApplyPreset(preset, True)
    table.RescaleTransferFunction(0.0, high)
    table.AutomaticRescaleRangeMode = "Never"
    shown.SetScalarBarVisibility(simple.GetActiveView(), True)
    bar = simple.GetScalarBar(table, simple.GetActiveView())
    bar.Title, bar.ComponentTitle = title, ""
    bar.TitleColor = bar.LabelColor = [0.0, 0.0, 0.0]


def names_by_type(sources):
    """Sources of bodies and of contact pressures."""
    bodies = {n: s for n, s in sources.items() if not n.endswith(".pressure")}
    return bodies, {n: s for n, s in sources.items() if n.endswith(".pressure")}


def show_result(sources, times, view):
    bodies, pressures = names_by_type(sources)
    stress, at = largest(bodies.values(), times, STRESS)
    pressure, _ = largest(pressures.values(), times, PRESSURE)
    for source in bodies.values():
        shown = simple.Show(source, view)
        shown.NonlinearSubdivisionLevel = 3
        source.UpdatePipeline(at)
        if stress > 0.0 and point_range(source, STRESS) is not None:
            coloured(shown, STRESS, stress, "von Mises stress [Pa]", "Viridis (matplotlib)")
        else:
            shown.DiffuseColor = BODY
    for source in pressures.values():
        shown = simple.Show(source, view)
        shown.SetRepresentationType("Point Gaussian")
        # A sixtieth of the loaded area's width when it is widest: points do not hide each other.
        source.UpdatePipeline(at)
        bounds = source.GetDataInformation().GetBounds()
        width = max(bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4])
        shown.GaussianRadius = width / 60.0 if width > 0.0 else 1e-6
        if pressure > 0.0:
            coloured(shown, PRESSURE, pressure, "contact pressure [Pa]", "Inferno (matplotlib)")
    return at


def show_scenario(sources, view):
    for name, source in sources.items():
        block = name.partition("/")[0]
        shown = simple.Show(source, view)
        source.UpdatePipeline()
        if block == "bodies":
            shown.NonlinearSubdivisionLevel = 3
            shown.DiffuseColor, shown.Opacity = BODY, 0.5
        elif name.endswith(".plane"):
            shown.DiffuseColor, shown.Opacity = BODY, 0.2
        elif block in ("loads", "gravity"):
            fields = source.PointData.keys()
            drawn = next((f for f in fields if f.startswith(("largest", "gravity"))), None)
            if drawn is not None:
                arrow = simple.Glyph(Input=source, GlyphType="Arrow")
                arrow.OrientationArray = ["POINTS", drawn]
                arrow.ScaleArray = ["POINTS", "No scale array"]
                arrow.ScaleFactor = 0.15 * extent(sources)
                simple.Show(arrow, view).DiffuseColor = [0.8, 0.1, 0.1]
        else:
            colour, width = MARKS.get(block, ([0.0, 0.0, 0.0], 2))
            shown.AmbientColor = shown.DiffuseColor = colour
            shown.LineWidth, shown.PointSize = width, 3 * width
            shown.RenderPointsAsSpheres = 1


def extent(sources):
    """Diagonal of the box around all sources that are drawn to scale."""
    low, high = [float("inf")] * 3, [float("-inf")] * 3
    for source in sources.values():
        bounds = source.GetDataInformation().GetBounds()
        for k in range(3):
            low[k], high[k] = min(low[k], bounds[2 * k]), max(high[k], bounds[2 * k + 1])
    return sum((h - l) ** 2 for l, h in zip(low, high) if h > l) ** 0.5


def main():
    parser = argparse.ArgumentParser(description="Shows an export of fbimpact in ParaView")
    # ParaView's window gives scripts no arguments.
    shown = os.environ.get("FBIMPACT_EXPORT")
    parser.add_argument("export", type=pathlib.Path, nargs="?", default=shown and pathlib.Path(shown))
    parser.add_argument("--picture", type=pathlib.Path)
    parser.add_argument("--time", type=float)
    given = parser.parse_args()
    if given.export is None:
        parser.error("name an export, as an argument or in FBIMPACT_EXPORT")
    parts = parts_of(given.export)
    if not parts:
        sys.exit(f"{given.export}: holds no parts")
    view = simple.GetActiveViewOrCreate("RenderView")
    view.UseColorPaletteForBackground = 0
    view.Background = [1.0, 1.0, 1.0]
    view.OrientationAxesLabelColor = [0.0, 0.0, 0.0]
    sources, times = {}, sorted({time for files in parts.values() for time, _ in files})
    for name, files in parts.items():
        sources[name] = simple.XMLUnstructuredGridReader(registrationName=name, FileName=[str(f) for _, f in files])
        sources[name].TimeArray = "TimeValue"
    if given.export.suffix == ".vtm":
        show_scenario(sources, view)
        at = 0.0
    else:
        at = show_result(sources, times, view)
    simple.GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
    view.ViewTime = given.time if given.time is not None else at
    # Flat models and sections are looked at along the axis that they lack.
    bounds = [source.GetDataInformation().GetBounds() for source in sources.values()]
    is_flat = lambda k: max(b[2 * k + 1] for b in bounds) - min(b[2 * k] for b in bounds) <= 1e-9 * extent(sources)
    if is_flat(1):
        simple.ResetActiveCameraToPositiveY()
    elif not is_flat(2):
        view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [1.0, -1.0, 0.6], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]
    simple.ResetCamera(view)
    simple.Render(view)
    if given.picture is not None:
        simple.SaveScreenshot(str(given.picture), view, ImageResolution=[1600, 1000])
        print(given.picture)


main()
