"""Shows an export of `fbimpact export` in ParaView: bodies by von Mises stress in one scale for all instants, contact pressure as points,
joints, loads and names of a scenario. `fbimpact export` writes it beside the files that it shows.

    paraview --script=PICTURES/NAME/show.py
    pvpython PICTURES/NAME/show.py --picture OUT.png [--time T]
    pvpython PICTURES/NAME/show.py --movie OUT.avi

Without `--time` a picture is of the instant of the largest von Mises stress. Needs ParaView 5.10; rational cells (exports without
`--plain`) are drawn right from 5.12 on. It shows another export if FBIMPACT_EXPORT names one.
"""

import argparse
import os
import pathlib
import sys
import xml.etree.ElementTree as ElementTree

import numpy
from paraview import servermanager, simple
from paraview.vtk.util.numpy_support import vtk_to_numpy

EXPORT = None
SIZE = [1600, 1000]  # pixels of pictures
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


def written(movie):
    """When a film was written, or the first picture of one; none if it was not."""
    first = movie.with_name(f"{movie.stem}.0000.png") if movie.suffix == ".png" else movie
    return first.stat().st_mtime_ns if first.is_file() else None


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


def sizes_of_points(data):
    """Length, area or volume that each point of a mesh stands for, by the boxes about its cells."""
    box = numpy.array(data.GetBounds()).reshape(3, 2)
    has_extent = box[:, 1] - box[:, 0] > 1e-9 * numpy.max(box[:, 1] - box[:, 0])
    sizes = numpy.zeros(data.GetNumberOfPoints())
    for number in range(data.GetNumberOfCells()):
        cell = data.GetCell(number)
        of_cell = numpy.array(cell.GetBounds()).reshape(3, 2)
        ids = [cell.GetPointId(k) for k in range(cell.GetNumberOfPoints())]
        numpy.add.at(sizes, ids, numpy.prod((of_cell[:, 1] - of_cell[:, 0])[has_extent]) / len(ids))
    return sizes


def exceeded(sources, time, name, percent):
    """The value of a field that all but a share of the volume of all sources has at an instant at most: places that are small beside
    the bodies, as contact zones and edges, do not take all colours."""
    values, sizes = [], []
    for source in sources:
        source.UpdatePipeline(time)
        data = servermanager.Fetch(source)
        field = data.GetPointData().GetArray(name)
        if field is not None and field.GetNumberOfTuples() > 0:
            values.append(vtk_to_numpy(field))
            sizes.append(sizes_of_points(data))
    if not values:
        return 0.0
    values, sizes = numpy.concatenate(values), numpy.concatenate(sizes)
    order = numpy.argsort(values)
    below = numpy.cumsum(sizes[order])
    at = numpy.searchsorted(below, percent / 100.0 * below[-1])
    return float(values[order][min(at, len(order) - 1)])


def coloured(shown, name, high, preset, height):
    """Colours of a field from zero to `high`, with their bar at a height of the picture."""
    simple.ColorBy(shown, ("POINTS", name))
    table = simple.GetColorTransferFunction(name)
    table.ApplyPreset(preset, True)
    table.RescaleTransferFunction(0.0, high)
    table.AutomaticRescaleRangeMode = "Never"
    shown.SetScalarBarVisibility(simple.GetActiveView(), True)
    bar = simple.GetScalarBar(table, simple.GetActiveView())
    bar.Title, bar.ComponentTitle = name, ""
    bar.TitleColor = bar.LabelColor = [0.0, 0.0, 0.0]
    bar.WindowLocation = "Any Location" if "Any Location" in bar.GetProperty("WindowLocation").Available else "AnyLocation"
    bar.Position, bar.ScalarBarLength = [0.88, height], 0.36


def names_by_type(sources):
    """Sources of bodies and of contact pressures."""
    bodies = {n: s for n, s in sources.items() if not n.endswith(".pressure")}
    return bodies, {n: s for n, s in sources.items() if n.endswith(".pressure")}


def show_result(sources, times, percent):
    view = simple.GetActiveView()
    bodies, pressures = names_by_type(sources)
    _, at = largest(bodies.values(), times, STRESS)
    stress = exceeded(bodies.values(), at, STRESS, percent)
    pressure, _ = largest(pressures.values(), times, PRESSURE)
    for source in bodies.values():
        shown = simple.Show(source, view)
        shown.NonlinearSubdivisionLevel = 3
        source.UpdatePipeline(at)
        if stress > 0.0 and point_range(source, STRESS) is not None:
            coloured(shown, STRESS, stress, "Viridis (matplotlib)", 0.54)
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
            coloured(shown, PRESSURE, pressure, "Inferno (matplotlib)", 0.08)
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


def show_time(view):
    clock = simple.AnnotateTime()
    # Versions differ in how numbers are written there.
    clock.Format = "{time:.6g} s" if "{" in clock.Format else "%.6g s"
    shown = simple.Show(clock, view)
    shown.Color = [0.0, 0.0, 0.0]


def own_export():
    """The export that this script was written for, where it is now or where it was."""
    try:
        folder = pathlib.Path(__file__).resolve().parent
    except NameError:
        return EXPORT
    beside = [folder.parent / (folder.name + ending) for ending in (".pvd", ".vtm")]
    return next((path for path in beside if path.is_file()), EXPORT)


def main():
    parser = argparse.ArgumentParser(description="Shows an export of fbimpact in ParaView")
    # ParaView's window gives scripts no arguments.
    shown = os.environ.get("FBIMPACT_EXPORT") or own_export()
    parser.add_argument("export", type=pathlib.Path, nargs="?", default=shown and pathlib.Path(shown))
    parser.add_argument("--picture", type=pathlib.Path)
    parser.add_argument("--time", type=float)
    parser.add_argument("--movie", type=pathlib.Path)
    parser.add_argument("--rate", type=int, default=25, help="pictures a second")
    parser.add_argument("--percent", type=float, default=99.0, help="share of the volume whose stress has colours of its own")
    given = parser.parse_args()
    if given.export is None:
        parser.error("name an export, as an argument or in FBIMPACT_EXPORT")
    parts = parts_of(given.export)
    if not parts:
        sys.exit(f"{given.export}: holds no parts")
    view = simple.GetActiveViewOrCreate("RenderView")
    view.ViewSize = SIZE
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
        at = show_result(sources, times, given.percent)
        show_time(view)
    simple.GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
    view.ViewTime = given.time if given.time is not None else at
    # Flat models and sections are looked at along the axis that they lack.
    bounds = [source.GetDataInformation().GetBounds() for source in sources.values()]
    is_flat = lambda k: max(b[2 * k + 1] for b in bounds) - min(b[2 * k] for b in bounds) <= 1e-9 * extent(sources)
    if is_flat(1):
        view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [0.0, -1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]
    elif not is_flat(2):
        view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [1.0, -1.0, 0.6], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]
    simple.ResetCamera(view)
    simple.Render(view)
    if given.picture is not None:
        simple.SaveScreenshot(str(given.picture), view, ImageResolution=SIZE)
        print(given.picture)
    if given.movie is not None:
        before = written(given.movie)
        simple.SaveAnimation(str(given.movie), view, ImageResolution=SIZE, FrameRate=given.rate, FrameWindow=[0, len(times) - 1])
        if written(given.movie) == before:
            sys.exit(f"Error: this ParaView has written no {given.movie.suffix} film; take .avi, .ogv or .png")
        print(given.movie)


main()
