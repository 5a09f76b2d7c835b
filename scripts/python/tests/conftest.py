"""Results that several tests read."""

from __future__ import annotations

import pathlib

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def scenarios() -> pathlib.Path:
    return ROOT / "scenarios"


@pytest.fixture(scope="session")
def ball(scenarios: pathlib.Path, tmp_path_factory: pytest.TempPathFactory):
    """A ball that hits a plane."""
    import fbimpact

    folder = tmp_path_factory.mktemp("ball")
    changes = {"output.points": {"top": {"body": "ball", "marker": "top"}}}
    return fbimpact.run(scenarios / "sphere_on_plane.toml", changes, output=folder / "ball.h5", threads=1)


@pytest.fixture(scope="session")
def pendulums(scenarios: pathlib.Path, tmp_path_factory: pytest.TempPathFactory):
    """Joints, and an impact that was refined."""
    import fbimpact

    folder = tmp_path_factory.mktemp("pendulums")
    scenario = fbimpact.read_scenario(scenarios / "rigid_double_pendulums.toml")
    scenario = fbimpact.override(scenario, {"simulation.end_time": 0.2})
    return fbimpact.run(scenario, output=folder / "pendulums.h5", threads=1)
