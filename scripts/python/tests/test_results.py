import math
import os

import h5py
import numpy as np
import pytest
import xarray as xr

import fbimpact


def test_groups_have_dimensions_units_and_the_numbers_of_the_file(ball):
    force = ball.contacts["impact"]["normal_force"]
    assert force.dims == ("time",) and force.attrs["units"] == "N" and force["time"].attrs["units"] == "s"
    position = ball.bodies["ball"]["position"]
    assert position.dims == ("time", "xyz") and list(position["xyz"].values) == ["x", "y", "z"]
    modes = ball.bodies["ball"]["elastic_coordinates"]
    assert modes.dims == ("time", "eigenfrequencies") and modes["eigenfrequencies"].attrs["units"] == "Hz"
    with h5py.File(ball.path) as file:
        assert np.array_equal(force.values, file["contacts/impact/normal_force"][:])
        assert np.array_equal(position.values, file["bodies/ball/position"][:])
        # Every numeric dataset over time is reachable by its path, with its unit and a description.
        seen = []

        def visit(name, item):
            if isinstance(item, h5py.Dataset) and item.ndim > 0 and item.dims[0].label == "time":
                read = ball[name]
                assert isinstance(read, xr.DataArray) and read.attrs["units"] == item.attrs["unit"], name
                assert read.attrs["long_name"] == item.attrs["description"], name
                assert np.array_equal(read.values, item[:], equal_nan=True), name
                seen.append(name)

        file.visititems(visit)
    assert len(seen) > 25


def test_joints_with_their_coordinates(pendulums):
    hinge = pendulums.joints["left_hinge"]
    assert hinge["coordinates"].dims == ("time", "coordinate") and hinge["velocities"].dims == ("time", "rate")
    assert list(hinge["coordinate"].values) == ["angle"]
    # The scenario's angle at the start, round-off of degrees.
    angle = pendulums.scenario["joints"]["left_hinge"]["angle"]
    assert math.isclose(hinge["coordinates"].values[0, 0], angle, rel_tol=1e-12)
    assert sorted(pendulums.joints) == ["left_hinge", "left_suspension", "right_hinge", "right_suspension"]
    with pytest.raises(KeyError, match="left_hinge"):
        pendulums.joints["hinge"]


def test_tables_have_columns_with_units(ball):
    table = ball.impacts
    assert table.sizes["impacts"] == 1 and table["peak_force"].attrs["units"] == "N"
    assert table.sel(impacts=1)["peak_force"] == table["peak_force"][0], "rows are numbered from 1"
    assert table["contact"].item() == "impact"
    assert ball.tries["interval_widths"].dims == ("tries", "interval_widths_component")
    assert ball.phases["kind"].values.tolist() == ["impact"] or "free" in ball.phases["kind"].values
    assert ball.transfers.sizes["transfers"] == 0
    assert ball.events["kind"].values.tolist() == ["touch", "release"]
    assert ball.table("impacts").identical(ball["impacts"])


def test_pressure_times_area_is_the_stored_force(ball):
    series = ball.contacts["impact"]["normal_force"]
    for time in ("peak", 2.0e-5, float(series["time"].values[-1])):
        found = ball.pressure("impact", time)
        stored = float(series.sel(time=found["time"].item()).values.max())
        # Pressures are stored in single precision.
        assert abs(float((found["pressure"] * found["area"]).sum()) - stored) <= 1e-6 * float(series.max())
    assert ball.pressure("impact")["position"].dims == ("point", "xyz")


def test_scenario_has_defaults_and_metric_agrees_with_the_series(ball):
    assert ball.scenario["bodies"]["ball"]["velocity"] == [0.0, 0.0, -0.1]
    peak = ball.metric("max(contacts.impact.normal_force)")
    assert peak.unit == "N" and peak.value == float(ball["contacts/impact/normal_force"].max())
    assert math.isnan(float(ball.metric("0/0")))
    with pytest.raises(fbimpact.CommandError, match="impct"):
        ball.metric("max(contacts.impct.normal_force)")


def test_probe_of_a_point_is_what_the_run_observed(ball):
    [top] = ball.probe("ball", markers=["top"])
    observed = ball.points["top"]["position"]
    # The same model and states: round-off of centimetres.
    assert np.abs(top["position"].values - observed.values).max() < 1e-12
    assert top["position"].attrs["units"] == "m" and top["position"].dims == ("time", "xyz")
    [inside] = ball.probe("ball", points=[(0.0, 0.001)], end=1e-6)
    assert list(inside["component"].values) == ["rr", "zz", "tt", "rz"]
    assert inside["stress"].attrs["units"] == "Pa" and inside["von_mises"].dims == ("time",)


def test_what_is_no_result_is_refused(tmp_path):
    with pytest.raises(fbimpact.FileError):
        fbimpact.open_result(tmp_path / "none.h5")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = 1
    with pytest.raises(fbimpact.FileError, match="not a result file"):
        fbimpact.open_result(tmp_path / "other.h5")
    with h5py.File(tmp_path / "new.h5", "w") as file:
        file.attrs["format"], file.attrs["format_version"] = "fbimpact", 3
    with pytest.raises(fbimpact.FileError, match="format version 3"):
        fbimpact.open_result(tmp_path / "new.h5")


def of_one_file(path, **others):
    """The least that is a result, with what `others` add."""
    with h5py.File(path, "w") as file:
        file.attrs["format"], file.attrs["format_version"], file.attrs["status"] = "fbimpact", 1, "complete"
        file["scenario"], file["time"] = "", [0.0]
        for name, make in others.items():
            make(file, name)
    return path


def test_nothing_outside_the_file_is_read(tmp_path):
    of_one_file(tmp_path / "secret.h5")
    (tmp_path / "secret.bin").write_bytes(bytes(64))
    virtual = h5py.VirtualLayout(shape=(1,), dtype="f8")
    virtual[:] = h5py.VirtualSource(str(tmp_path / "secret.h5"), "time", shape=(1,))
    whole = (2**40,)
    for words, make in (
        ("link into another file", lambda file, name: file.__setitem__(name, h5py.ExternalLink(str(tmp_path / "secret.h5"), "/time"))),
        ("link into another file", lambda file, name: file.create_group("a/b").__setitem__(name, h5py.ExternalLink("secret.h5", "/time"))),
        ("lies in other files", lambda file, name: file.create_dataset(name, (8,), "f8", external=[(str(tmp_path / "secret.bin"), 0, 64)])),
        ("lies in other files", lambda file, name: file.create_virtual_dataset(name, virtual)),
        ("more than the file holds", lambda file, name: file.create_dataset(name, whole, "f8", chunks=(1024,))),
    ):
        with pytest.raises(fbimpact.FileError, match=words):
            fbimpact.open_result(of_one_file(tmp_path / "made.h5", force=make))
    # Texts longer than the file, and a heap of texts that never ends: HDF5 would take the memory, and the time.
    with h5py.File(of_one_file(tmp_path / "long.h5")) as file:
        at = file["scenario"].id.get_offset()
    sound = (tmp_path / "long.h5").read_bytes()
    heap = sound.index(b"GCOL")
    free = heap + 16 + 16 + -(-int.from_bytes(sound[heap + 24 : heap + 32], "little") // 8) * 8
    for words, place, new in (("a text of 4294967280 bytes", at, b"\xf0\xff\xff\xff"), ("texts at byte .* are damaged", free, bytes(16))):
        (tmp_path / "long.h5").write_bytes(sound[:place] + new + sound[place + len(new) :])
        with pytest.raises(fbimpact.FileError, match=words):
            fbimpact.open_result(tmp_path / "long.h5")
    # A link within the file is no way out.
    linked = fbimpact.open_result(of_one_file(tmp_path / "soft.h5", again=lambda file, name: file.__setitem__(name, h5py.SoftLink("/time"))))
    assert linked["again"].values.tolist() == [0.0]


def test_what_is_no_whole_result_is_told(tmp_path):
    os.mkfifo(tmp_path / "pipe.h5")
    for name, words in (("pipe.h5", "pipe or device"), (".", "folder"), ("none.h5", "No such file")):
        with pytest.raises(fbimpact.FileError, match=words):
            fbimpact.open_result(tmp_path / name)
    os.mkfifo(tmp_path / "pipe.toml")
    with pytest.raises(fbimpact.FileError, match="pipe or device"):
        fbimpact.read_scenario(tmp_path / "pipe.toml")

    def without(attribute):
        return lambda file, _: file.attrs.__delitem__(attribute)

    for words, change in (
        ("no status", without("status")),
        ("not a result file", without("format")),
        ("no scenario", lambda file, _: file.__delitem__("scenario")),
        ("format version 3.*read it with", lambda file, _: file.attrs.__setitem__("format_version", 3)),
        ("format version", lambda file, _: file.attrs.__setitem__("format_version", [1, 2])),
        ("format version", lambda file, _: file.attrs.__setitem__("format_version", "1.5")),
    ):
        with pytest.raises(fbimpact.FileError, match=words):
            fbimpact.open_result(of_one_file(tmp_path / "changed.h5", change=change))
    assert fbimpact.open_result(of_one_file(tmp_path / "old.h5", change=without("format_version"))).status == "complete"
