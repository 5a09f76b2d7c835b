"""Runs fbimpact and reads its results: see docs/python.md."""

from .program import CommandError, Error, FileError, Interrupted, ModelError, RunFailed, ScenarioError, find_program
from .results import Metric, Result, open_result
from .runs import check, run
from .sampling import full_factorial, latin_hypercube
from .scenario import override, read_scenario, write_scenario
from .sweeps import Sweep, SweepRun, sweep

__all__ = [
    "CommandError",
    "Error",
    "FileError",
    "Interrupted",
    "Metric",
    "ModelError",
    "Result",
    "RunFailed",
    "ScenarioError",
    "Sweep",
    "SweepRun",
    "check",
    "find_program",
    "full_factorial",
    "latin_hypercube",
    "open_result",
    "override",
    "read_scenario",
    "run",
    "sweep",
    "write_scenario",
]
