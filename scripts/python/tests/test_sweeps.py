import json
import math
import os
import pathlib
import signal
import subprocess
import sys
import time

import pytest

import fbimpact

ROOT = pathlib.Path(__file__).resolve().parents[3]


def test_failed_runs_are_rows_and_finished_ones_are_not_made_again(scenarios, tmp_path):
    path = scenarios / "sphere_on_plane.toml"
    values = {"bodies.ball.velocity[2]": [-0.05, -0.1], "materials.aluminium.youngs_modulus": [72.8e9, -1.0]}
    said = []
    made = fbimpact.sweep(path, values, tmp_path, jobs=2, progress=lambda run, n, of: said.append((n, of)))
    assert [n for n, _ in said] == [1, 2, 3, 4] and {of for _, of in said} == {4}
    assert len(made.runs) == 4 and [run.exit_code for run in made.failed] == [3, 3]
    assert "youngs_modulus" in made.failed[0].log
    table = made.table({"late": "bodies.ball.velocity[-1].z"})
    assert list(table["status"].values) == ["complete", "failed", "complete", "failed"]
    peaks = table["impact[1].peak_force"].values
    # Hertz: the force grows with the speed to the power of 1.2; waves in the ball leave 2e-3 (docs/verification.md).
    assert math.isclose(peaks[2] / peaks[0], 2.0**1.2, rel_tol=2e-3) and math.isnan(peaks[1])
    assert table["impact[1].peak_force"].attrs["units"] == "N" and table["late"].values[0] > 0.04
    stamps = {run.name: run.path.stat().st_mtime_ns for run in made.runs if run.is_complete}
    again = fbimpact.sweep(path, {**values, "materials.aluminium.youngs_modulus": [72.8e9]}, tmp_path, jobs=2)
    assert not again.failed
    assert all(run.path.stat().st_mtime_ns == stamps[run.name] for run in again.runs)
    assert [m.value for m in again.metric("max(impacts.peak_force)")] == [peaks[0], peaks[2]]
    with pytest.raises(ValueError, match="another folder"):
        fbimpact.sweep(scenarios / "rod_on_plane.toml", values, tmp_path)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "plan").write_text("of a house")
    with pytest.raises(fbimpact.FileError, match="of no sweep"):
        fbimpact.sweep(path, values, tmp_path / "mine")


def test_what_has_changed_runs_again(tmp_path):
    scenario = {
        "simulation": {"end_time": 1e-3},
        "bodies": {"block": {"model": "rigid", "mass": 0.5, "inertia": [1e-4] * 3}},
        "loads": {"push": {"body": "block", "point": [0.0] * 3, "force_x": {"kind": "table", "file": "push.csv"}}},
    }
    values = {"bodies.block.mass": [1.0, 2.0]}

    def stamps(folder):
        return [run.path.stat().st_mtime_ns for run in fbimpact.sweep(scenario, values, folder).runs]

    (tmp_path / "-$(touch RAN)").mkdir()
    for folder in (tmp_path / "-$(touch RAN)", tmp_path / "o'neill"):
        folder.mkdir(exist_ok=True)
        (folder / "push.csv").write_text("t,F\n0,0\n1,10\n")
        first = stamps(folder)
        assert stamps(folder) == first
        (folder / "push.csv").write_text("t,F\n0,0\n1,20\n")
        second = stamps(folder)
        assert all(a != b for a, b in zip(first, second))
        scenario["simulation"]["end_time"] += 1e-3
        assert all(a != b for a, b in zip(second, stamps(folder)))
        scenario["simulation"]["end_time"] = 1e-3


def test_a_sweep_is_a_grid_with_numeric_axes(scenarios, tmp_path):
    path = scenarios / "sphere_on_plane.toml"
    values = {
        "bodies.ball.velocity": [[0.0, 0.0, -0.1], [0.0, 0.0, -0.05]],
        "materials.aluminium.youngs_modulus": [72.8e9, -1.0, 36.4e9],
    }
    made = fbimpact.sweep(path, values, tmp_path, jobs=2)
    grid = made.grid({"late": "bodies.ball.velocity[-1].z"})
    assert dict(grid.sizes) == {"bodies.ball.velocity[2]": 2, "materials.aluminium.youngs_modulus": 3}
    assert list(grid["bodies.ball.velocity[2]"].values) == [-0.1, -0.05]
    peak = grid["impact[1].peak_force"]
    assert peak.attrs["units"] == "N" and math.isnan(peak.sel({"materials.aluminium.youngs_modulus": -1.0})[0])
    # Hertz: the force grows with the modulus to the power of 0.4; waves in the ball leave 1e-2.
    stiff, soft = (peak.sel({"materials.aluminium.youngs_modulus": e})[0].item() for e in (72.8e9, 36.4e9))
    assert math.isclose(stiff / soft, 2.0**0.4, rel_tol=1e-2)
    assert "late" in grid and "status" not in grid
    impacts = made.impacts()
    assert dict(impacts.sizes) == {**grid.sizes, "impacts": 1} and list(impacts["impacts"].values) == [1]
    assert impacts["peak_force"].sel(impacts=1).equals(peak.rename("peak_force").drop_vars("impacts", errors="ignore").assign_coords(impacts=1))
    assert impacts["start"].attrs["units"] == "s" and "contact" not in impacts
    both = fbimpact.Sweep(tmp_path, [fbimpact.SweepRun(n, {"v": v}, tmp_path) for n, v in (("a", [0.0, 1.0]), ("b", [1.0, 0.0]))])
    with pytest.raises(ValueError, match="several components"):
        both.grid()


def test_shell_and_package_go_on_with_each_other(scenarios, tmp_path):
    path = scenarios / "sphere_on_plane.toml"
    made = fbimpact.sweep(path, {"bodies.ball.velocity[2]": [-0.05]}, tmp_path)
    [run] = made.runs
    stamp = run.path.stat().st_mtime_ns
    environment = {**os.environ, "FBIMPACT": fbimpact.find_program(), "JOBS": "1"}
    script = [str(ROOT / "scripts/sweep.sh"), str(path), str(tmp_path), "bodies.ball.velocity[2]=-0.05 -0.06"]
    subprocess.run(script, env=environment, check=True, capture_output=True)
    assert run.path.stat().st_mtime_ns == stamp
    assert len(list(tmp_path.glob("run-*.h5"))) == 2


def test_interrupted_sweep_stops_its_runs_and_goes_on(scenarios, tmp_path):
    path = scenarios / "rigid_double_pendulums.toml"
    # Started in the background of a shell, a process has its interrupt ignored.
    program = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
    program += f"import fbimpact; fbimpact.sweep({str(path)!r}, {{'simulation.end_time': [50.0, 60.0]}}, {str(tmp_path)!r}, jobs=2)"
    process = subprocess.Popen([sys.executable, "-c", program], stderr=subprocess.DEVNULL)
    # A restart point comes with the first phase, long before the fifty seconds of the runs are computed.
    deadline = time.monotonic() + 60.0
    while len(list(tmp_path.glob("run-*.h5.restart"))) < 2 and time.monotonic() < deadline:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=60) != 0
    codes = [int(file.read_text()) for file in tmp_path.glob("run-*.exit")]
    assert codes == [130, 130], "both runs were told to stop and stored what they had"
    assert len(list(tmp_path.glob("run-*.h5.restart"))) == 2


def test_latin_hypercube_has_one_sample_in_each_part():
    ranges = {"a": (2.0, 4.0), "b": (1.0, 1e4, "log"), "c": (-1.0, 1.0)}
    for n in (1, 2, 7, 40):
        rows = fbimpact.latin_hypercube(ranges, n, seed=3, keep=20)
        parts = {
            "a": sorted(int((row["a"] - 2.0) / 2.0 * n) for row in rows),
            "b": sorted(int(math.log(row["b"]) / math.log(1e4) * n) for row in rows),
            "c": sorted(int((row["c"] + 1.0) / 2.0 * n) for row in rows),
        }
        assert all(part == list(range(n)) for part in parts.values()), (n, parts)
    assert fbimpact.latin_hypercube(ranges, 5, seed=1) == fbimpact.latin_hypercube(ranges, 5, seed=1)
    assert fbimpact.latin_hypercube(ranges, 5, seed=1) != fbimpact.latin_hypercube(ranges, 5, seed=2)

    def nearest(keep):
        # In parts of the ranges of a and c.
        rows = fbimpact.latin_hypercube({"a": (0.0, 1.0), "c": (0.0, 1.0)}, 12, seed=5, keep=keep)
        points = [tuple(row.values()) for row in rows]
        return min(math.dist(p, q) for i, p in enumerate(points) for q in points[:i])

    assert nearest(200) > nearest(1)
    assert fbimpact.full_factorial({"a": [1, 2], "b": [3]}) == [{"a": 1, "b": 3}, {"a": 2, "b": 3}]


def test_latin_hypercube_has_less_scatter_than_random_samples():
    import random
    import statistics

    # The mean of a sum of functions of one key each: the variance falls like n^-3 in place of n^-1 (Stein, Technometrics 29, 1987).
    def value(row):
        return row["a"] + row["b"] ** 2

    n, ranges = 20, {"a": (0.0, 1.0), "b": (0.0, 1.0)}
    cubes = [statistics.fmean(map(value, fbimpact.latin_hypercube(ranges, n, seed=s, keep=1))) for s in range(100)]
    source = random.Random(0)
    chance = [statistics.fmean(value({"a": source.random(), "b": source.random()}) for _ in range(n)) for _ in range(100)]
    # n^2 = 400 in the variance, 20 in the scatter; a hundred estimates of it are right to a tenth.
    assert statistics.stdev(chance) > 10 * statistics.stdev(cubes)
    exact = 0.5 + 1.0 / 3.0
    assert abs(statistics.fmean(cubes) - exact) < 4 * statistics.stdev(cubes) / math.sqrt(100)


def test_ranges_that_are_none_are_refused():
    for limits in ((1.0, 1.0), (2.0, 1.0), (0.0, 1.0, "log"), (1.0, 2.0, "ln"), (0.0, math.inf)):
        with pytest.raises(ValueError, match="key"):
            fbimpact.latin_hypercube({"key": limits}, 3)
    with pytest.raises(ValueError):
        fbimpact.latin_hypercube({"key": (0.0, 1.0)}, 0)


def test_sampling_as_a_command_feeds_the_shell(scenarios, tmp_path):
    command = [sys.executable, str(ROOT / "scripts/python/fbimpact/sampling.py"), "3"]
    ranges = ["bodies.ball.velocity[2]=-0.2..-0.05", "materials.aluminium.youngs_modulus=60e9..80e9:log"]
    word = subprocess.run([*command, *ranges], check=True, capture_output=True, text=True).stdout.strip()
    environment = {**os.environ, "FBIMPACT": fbimpact.find_program(), "JOBS": "2"}
    script = [str(ROOT / "scripts/sweep.sh"), str(scenarios / "sphere_on_plane.toml"), str(tmp_path), word]
    subprocess.run(script, env=environment, check=True, capture_output=True)
    assert len(list(tmp_path.glob("run-*.h5"))) == 3
    wrong = subprocess.run([*command, "velocity=3"], capture_output=True, text=True)
    assert wrong.returncode != 0 and "KEY=LOW..HIGH" in wrong.stderr


@pytest.mark.parametrize("hostile", ["x;touch RAN;$(touch RAN) `touch RAN`", "o'neill \"a\\b && touch RAN #", "-ö*?[a]"])
def test_snakemake_takes_any_name_for_a_name(tmp_path, hostile):
    pytest.importorskip("snakemake")
    (tmp_path / f"{hostile}.toml").write_text("[simulation]\nend_time = 1e-3\n[bodies.block]\nmodel = 'rigid'\nmass = 0.5\ninertia = [1e-4, 1e-4, 1e-4]\n")
    configuration = {"scenario": f"{hostile}.toml", "folder": f"out {hostile}", "grid": "bodies.block.mass=1 2"}
    (tmp_path / "config.json").write_text(json.dumps(configuration))
    command = [sys.executable, "-m", "snakemake", "-s", str(ROOT / "scripts" / "Snakefile"), "--cores", "2", "--configfile", "config.json"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    table = (tmp_path / f"out {hostile}" / "table.csv").read_text()
    assert table.count(",complete,") == 2, table
    assert not list(tmp_path.rglob("RAN"))
