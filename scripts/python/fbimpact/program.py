"""The program: where it is, how it is called, what its exit codes mean."""

from __future__ import annotations

import os
import pathlib
import shutil
import subprocess
from collections.abc import Sequence


class Error(Exception):
    """A command failed. `exit_code` is that of the program, `message` what it said."""

    exit_code = 1

    def __init__(self, message: str, exit_code: int | None = None) -> None:
        super().__init__(message)
        self.message = message
        if exit_code is not None:
            self.exit_code = exit_code


class CommandError(Error):
    """The command line is wrong, such as an expression that names no dataset (exit code 2)."""

    exit_code = 2


class ScenarioError(Error):
    """The scenario has faults; the message lists all of them (exit code 3)."""

    exit_code = 3


class ModelError(Error):
    """A model cannot be built (exit code 4)."""

    exit_code = 4


class RunFailed(Error):
    """The run failed; what was computed until then can be read (exit code 5)."""

    exit_code = 5


class FileError(Error):
    """A file cannot be read or written (exit code 6)."""

    exit_code = 6


class Interrupted(Error):
    """The run was interrupted; what was computed until then can be read, and the run taken up (exit code 130)."""

    exit_code = 130


KINDS: dict[int, type[Error]] = {
    kind.exit_code: kind for kind in (CommandError, ScenarioError, ModelError, RunFailed, FileError, Interrupted)
}


def find_program() -> str:
    """Path of the program: `$FBIMPACT`, else `fbimpact` on the path, else what a checkout that holds this package has built.

    Raises `FileError` if there is none.
    """
    given = os.environ.get("FBIMPACT")
    if given:
        found = shutil.which(given)
        if found is None:
            raise FileError(f"FBIMPACT={given}: no such program")
        return found
    found = shutil.which("fbimpact")
    if found is not None:
        return found
    for folder in pathlib.Path(__file__).resolve().parents:
        built = folder / "target" / "release" / "fbimpact"
        if built.is_file():
            return str(built)
    raise FileError("no program fbimpact: put it on the path, or its path into the environment variable FBIMPACT")


def call(arguments: Sequence[str | os.PathLike[str]], *, log: bool = False) -> str:
    """Calls the program and returns its standard output; with `log` its messages go to standard error at once.

    Raises the `Error` of its exit code with what it said.
    """
    command = [find_program(), *(os.fspath(argument) for argument in arguments)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=None if log else subprocess.PIPE, text=True)
    if done.returncode != 0:
        raise error_of(done.returncode, done.stderr or "")
    return done.stdout


def error_of(exit_code: int, said: str) -> Error:
    """The error of an exit code. A negative one is that of a process ended by a signal."""
    message = said.strip() or f"fbimpact ended with {exit_code}"
    return KINDS.get(exit_code, Error)(message, exit_code)
