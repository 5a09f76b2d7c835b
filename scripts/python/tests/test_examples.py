"""Examples that drive the program from others. Each is run where its package is installed."""

import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys

import pytest

import fbimpact

EXAMPLES = pathlib.Path(__file__).resolve().parents[1] / "examples"
SCENARIO = EXAMPLES.parents[2] / "scenarios" / "sphere_on_plane.toml"


def said(command, folder, **environment):
    where = {**os.environ, "FBIMPACT": fbimpact.find_program(), **environment}
    where["PYTHONPATH"] = os.pathsep.join([str(EXAMPLES.parent), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run([str(c) for c in command], cwd=folder, env=where, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def needs(package):
    return pytest.mark.skipif(importlib.util.find_spec(package) is None, reason=f"{package} is not installed")


@needs("optuna")
def test_optuna_finds_the_speed(tmp_path):
    words = said([sys.executable, EXAMPLES / "optuna_peak.py", SCENARIO, "52.08", "20"], tmp_path).split()
    # The example's speed, 0.1 m/s. The search stops somewhere near: eight random samples of a decade and a third leave 17 % of the
    # speed between neighbours, twelve more a few per cent.
    assert abs(float(words[1]) - 0.1) < 0.01, words


@needs("openturns")
def test_openturns_finds_the_powers_of_hertz(tmp_path):
    lines = said([sys.executable, EXAMPLES / "openturns_peak.py", SCENARIO, "12"], tmp_path).splitlines()
    slopes = [float(line.rpartition(": ")[2]) for line in lines[:3]]
    # Hertz: E^0.4 rho^0.6 v^1.2. The ball yields elastically beside the contact as well: by 0.7 % of the force, which changes with the
    # contact radius over the radius of the ball, to the power of a half at most.
    for slope, wanted in zip(slopes, (0.4, 0.6, 1.2)):
        assert abs(slope - wanted) < 0.01, lines


def test_driver_for_dakota_answers_in_its_format(tmp_path):
    # As Dakota 6 writes it: variables, functions with their request, derivatives, components.
    text = """                                          2 variables
                     -2.000000000000000e-01 bodies.ball.velocity[2]
                      7.280000000000000e+10 materials.aluminium.youngs_modulus
                                          1 functions
                                          1 ASV_1:peak
                                          0 derivative_variables
                                          0 analysis_components
                                          1 eval_id
"""
    (tmp_path / "parameters.in").write_text(text)
    driver = [sys.executable, EXAMPLES / "dakota/driver.py", "parameters.in", "results.out"]
    said(driver, tmp_path, FBIMPACT_SCENARIO=str(SCENARIO))
    value, name = (tmp_path / "results.out").read_text().split()
    wanted = fbimpact.run(SCENARIO, {"bodies.ball.velocity[2]": -0.2}, output=tmp_path / "same.h5", threads=1)
    assert name == "peak" and float(value) == float(wanted.impacts["peak_force"][0])
    (tmp_path / "parameters.in").write_text(text.replace("7.28", "-7.28"))
    said(driver, tmp_path, FBIMPACT_SCENARIO=str(SCENARIO))
    assert (tmp_path / "results.out").read_text() == "FAIL\n"


@pytest.mark.skipif(shutil.which("dakota") is None, reason="dakota is not installed")
def test_dakota_runs_the_study(tmp_path):
    for name in ("study.in", "driver.py"):
        shutil.copy(EXAMPLES / "dakota" / name, tmp_path)
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    said(["dakota", "study.in"], tmp_path, FBIMPACT_SCENARIO=str(SCENARIO), PATH=path)
    assert len((tmp_path / "study.dat").read_text().splitlines()) == 9
