"""The program: where it is, how it is called, what its exit codes mean."""

from __future__ import annotations

import functools
import importlib.metadata
import os
import pathlib
import shutil
import subprocess
import sysconfig
import warnings
from collections.abc import Iterator, Sequence


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
    """Path of the program, the first that is there of: `$FBIMPACT`; the one that was installed with this package; `bin` beside it
    (`pip install --target`); what a checkout that holds it has built; `fbimpact` on the path; the user's scheme of Python.

    An environment need not be activated for it. Raises `FileError` if there is none.
    """
    given = os.environ.get("FBIMPACT")
    if given:
        found = shutil.which(given)
        if found is None:
            raise FileError(f"FBIMPACT={given}: no such program")
        return found
    for place in _places():
        if place is not None and os.access(place, os.X_OK) and pathlib.Path(place).is_file():
            return str(place)
    raise FileError("no program fbimpact: put it on the path, or its path into the environment variable FBIMPACT")


def _places() -> Iterator[str | os.PathLike[str] | None]:
    """Where the program may be, the nearest to this package first."""
    name = "fbimpact.exe" if os.name == "nt" else "fbimpact"
    package = pathlib.Path(__file__).resolve().parent
    yield _installed_with(package, name)
    yield package.parent / "bin" / name
    for folder in package.parents:
        if (folder / "Cargo.toml").is_file():
            yield folder / "target" / "release" / name
    yield shutil.which("fbimpact")
    yield pathlib.Path(sysconfig.get_path("scripts", f"{os.name}_user"), name)


def _installed_with(package: pathlib.Path, name: str) -> pathlib.Path | None:
    """The program among the files of the installed distribution whose package this is."""
    try:
        distribution = importlib.metadata.distribution("fbimpact")
    except importlib.metadata.PackageNotFoundError:
        return None
    files = [pathlib.Path(str(distribution.locate_file(file))) for file in distribution.files or []]
    if not any(file.name == "__init__.py" and file.parent.resolve() == package for file in files):
        return None
    programs = (file.resolve() for file in files if file.name == name and file.parent.name in ("bin", "Scripts"))
    return next((file for file in programs if file.is_file()), None)


@functools.lru_cache
def _warn_of_version(program: str) -> None:
    """Tells once of a program that is not of the version of this package."""
    try:
        package = importlib.metadata.version("fbimpact")
    except importlib.metadata.PackageNotFoundError:
        return
    said = subprocess.run([program, "--version"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout
    version = said.split("\n", 1)[0].removeprefix("fbimpact").strip()
    if version != package:
        warnings.warn(f"{program} is version {version or 'unknown'}, the Python package is {package}", stacklevel=3)


def call(arguments: Sequence[str | os.PathLike[str]], *, log: bool = False) -> str:
    """Calls the program and returns its standard output; with `log` its messages go to standard error at once.

    Raises the `Error` of its exit code with what it said.
    """
    program = find_program()
    _warn_of_version(program)
    command = [program, *map(_word, arguments)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=None if log else subprocess.PIPE, text=True)
    if done.returncode != 0:
        raise error_of(done.returncode, done.stderr or "")
    return done.stdout


def _word(argument: str | os.PathLike[str]) -> str:
    """An argument; no path is taken for an option."""
    word = os.fspath(argument)
    return f"./{word}" if word.startswith("-") and not isinstance(argument, str) else word


def error_of(exit_code: int, said: str) -> Error:
    """The error of an exit code. A negative one is that of a process ended by a signal."""
    message = said.strip() or f"fbimpact ended with {exit_code}"
    return KINDS.get(exit_code, Error)(message, exit_code)
