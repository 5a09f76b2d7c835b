import math
import pathlib
import shutil

import numpy as np
import pytest

import fbimpact
from fbimpact import program
from fbimpact.program import call
from fbimpact.scenario import path_of, to_toml


def test_every_scenario_survives_being_written_again(scenarios, tmp_path):
    for path in sorted(scenarios.rglob("*.toml")):
        scenario = fbimpact.read_scenario(path)
        again = fbimpact.write_scenario(scenario, tmp_path / "again.toml")
        assert fbimpact.read_scenario(again) == scenario, path
    fbimpact.check(fbimpact.read_scenario(scenarios / "sphere_on_plane.toml"))


def test_override_does_what_set_does(scenarios):
    path = scenarios / "sphere_on_plane.toml"
    changes = {
        "bodies.ball.velocity[2]": np.float64(-0.2),
        "bodies.ball.discretisation.refine[0].elements": 10,
        "output.points.top": {"body": "ball", "marker": "top"},
        "simulation.impact.rtol": 1e-7,
        "title": 'a "quoted" title, µ',
    }
    changed = fbimpact.override(fbimpact.read_scenario(path), changes)
    assert changed["bodies"]["ball"]["velocity"] == [0.0, 0.0, -0.2]
    assert changed["simulation"]["impact"] == {"rtol": 1e-7}
    assert fbimpact.read_scenario(path)["bodies"]["ball"]["velocity"] == [0.0, 0.0, -0.1]
    fbimpact.check(changed)
    fbimpact.check(path, changes)
    for key in ("bodies.bal.velocity[0]", "bodies.ball.velocity[7]", "bodies..x", "bodies.ball[0]"):
        with pytest.raises((KeyError, ValueError)):
            fbimpact.override(fbimpact.read_scenario(path), {key: 1.0})


def test_values_become_toml():
    assert to_toml([True, 1, 2.5, "a\"b", {"k": [np.float32(0.5)]}]) == '[true, 1, 2.5, "a\\"b", { "k" = [0.5] }]'
    assert to_toml(np.array([[1.0, 2.0]])) == "[[1.0, 2.0]]" and to_toml(1e-7) == "1e-07"
    assert path_of("a.b[0][12].c-d") == ["a", "b", 0, 12, "c-d"]
    for wrong in (math.nan, math.inf, None, object()):
        with pytest.raises((TypeError, ValueError)):
            to_toml(wrong)


def test_errors_have_their_kind_and_say_what_is_wrong(scenarios, tmp_path):
    path = scenarios / "sphere_on_plane.toml"
    with pytest.raises(fbimpact.ScenarioError, match="velocty") as error:
        fbimpact.check(path, {"bodies.ball.velocty": 1.0})
    assert error.value.exit_code == 3
    with pytest.raises(fbimpact.FileError):
        fbimpact.run(tmp_path / "none.toml")
    with pytest.raises(fbimpact.RunFailed, match="widen"):
        changes = {"bodies.ball.velocity": [0.0, 0.0, -2.0]}
        fbimpact.run(path, changes, output=tmp_path / "fast.h5", threads=1)
    failed = fbimpact.open_result(tmp_path / "fast.h5")
    assert failed.status == "failed" and "widen" in failed.message


def test_program_is_found(monkeypatch, tmp_path):
    there = fbimpact.find_program()
    monkeypatch.setenv("FBIMPACT", str(tmp_path / "none"))
    with pytest.raises(fbimpact.FileError, match="no such program"):
        fbimpact.find_program()
    monkeypatch.setenv("FBIMPACT", there)
    assert fbimpact.find_program() == there
    assert "fbimpact" in call(["--version"])
    # Without the variable: what lies nearest to the package. This one is in no checkout and was not installed.
    monkeypatch.delenv("FBIMPACT")
    package = tmp_path / "site" / "fbimpact"
    shutil.copytree(pathlib.Path(fbimpact.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(program, "__file__", str(package / "program.py"))
    monkeypatch.setattr(program, "_installed_with", lambda *_: None)
    on_path = stub(tmp_path / "path" / "fbimpact")
    monkeypatch.setenv("PATH", str(on_path.parent))
    assert fbimpact.find_program() == str(on_path)
    beside = stub(tmp_path / "site" / "bin" / "fbimpact")
    assert fbimpact.find_program() == str(beside)
    installed = stub(tmp_path / "environment" / "fbimpact")
    monkeypatch.setattr(program, "_installed_with", lambda *_: installed)
    assert fbimpact.find_program() == str(installed)
    checkout = stub(tmp_path / "target" / "release" / "fbimpact")
    (tmp_path / "Cargo.toml").touch()
    monkeypatch.setattr(program, "_installed_with", lambda *_: None)
    beside.unlink()
    assert fbimpact.find_program() == str(checkout)


def stub(path: pathlib.Path) -> pathlib.Path:
    """A file that may be executed."""
    path.parent.mkdir(parents=True)
    path.touch(mode=0o755)
    return path


def test_program_of_another_version_is_told(monkeypatch, tmp_path):
    other = stub(tmp_path / "bin" / "fbimpact")
    other.write_text("#!/bin/sh\necho fbimpact 9.9.9\n")
    monkeypatch.setenv("FBIMPACT", str(other))
    monkeypatch.setattr(program.importlib.metadata, "version", lambda _: "0.1.0")
    with pytest.warns(UserWarning, match="is version 9.9.9, the Python package is 0.1.0"):
        call(["--version"])


def test_figures_are_drawn(ball, pendulums):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    from fbimpact import figures

    axes = figures.impact([ball], 1)
    drawn = axes.lines[0].get_ydata()
    assert max(drawn) == float(ball["contacts/impact/normal_force"].max())
    with pytest.raises(IndexError, match="no impact 2"):
        figures.impact(ball, 2)
    assert len(figures.ledger(pendulums).lines) >= 3
    pressure = figures.pressure_map(ball, "impact").lines[0].get_ydata()
    assert max(pressure) == pytest.approx(1e-6 * float(ball.pressure("impact")["pressure"].max()))
    figures.spectrum(ball["bodies/ball/velocity"][:, 2])


def test_spectrum_of_a_harmonic_has_its_amplitude():
    import xarray as xr

    from fbimpact import figures

    # 25 whole periods on 1000 even instants: a line of the spectrum, its leakage in the window's two neighbours.
    time = np.linspace(0.0, 0.999, 1000)
    series = xr.DataArray(3.0 * np.sin(2 * np.pi * 25.0 * time), {"time": time}, ("time",), "x", {"units": "m"})
    found = figures.amplitudes(series)
    assert float(found["frequency"][found.values.argmax()]) == pytest.approx(25.0, rel=1e-12)
    assert float(found.max()) == pytest.approx(3.0, rel=1e-12)


def test_no_file_of_somebody_else_is_written(scenarios, tmp_path):
    mine = tmp_path / "drop.toml"
    mine.write_text("# my remarks\n" + (scenarios / "sphere_on_plane.toml").read_text())
    before = mine.read_text()
    # The same scenario needs not be written; another one is refused before anything runs, a faulty one too.
    fbimpact.run(fbimpact.read_scenario(mine), output=tmp_path / "drop.h5", threads=1)
    changed = fbimpact.override(fbimpact.read_scenario(mine), {"title": "another"})
    for scenario in (changed, {"bodies": {}}):
        with pytest.raises(fbimpact.FileError, match="choose another name"):
            fbimpact.run(scenario, output=tmp_path / "drop.h5")
        with pytest.raises(fbimpact.FileError, match="choose another name"):
            fbimpact.write_scenario(scenario, mine)
    for value in (object(), None):
        with pytest.raises(TypeError):
            fbimpact.write_scenario({"title": value}, tmp_path / "none.toml")
    assert mine.read_text() == before and not (tmp_path / "none.toml").exists()
    (tmp_path / "scenario.toml").write_text(before)
    with pytest.raises(fbimpact.FileError, match="choose another name"):
        fbimpact.sweep(changed, {"bodies.ball.velocity[2]": [-0.1]}, tmp_path)
    assert (tmp_path / "scenario.toml").read_text() == before and not (tmp_path / "plan").exists()
    # What the package wrote it replaces, unless somebody has changed it; a link is replaced and not followed.
    ours = fbimpact.write_scenario(changed, tmp_path / "ours.toml")
    fbimpact.write_scenario({"title": "third"}, ours)
    assert fbimpact.read_scenario(ours) == {"title": "third"}
    ours.write_text(ours.read_text() + "# kept\n")
    with pytest.raises(fbimpact.FileError, match="choose another name"):
        fbimpact.write_scenario(changed, ours)
    (tmp_path / "link.toml").symlink_to(ours)
    fbimpact.write_scenario(changed, tmp_path / "link.toml", force=True)
    assert "# kept" in ours.read_text() and fbimpact.read_scenario(tmp_path / "link.toml") == changed
    assert sorted(path.name for path in tmp_path.iterdir()) == ["drop.h5", "drop.toml", "link.toml", "ours.toml", "scenario.toml"]
