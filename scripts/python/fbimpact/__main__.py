"""`python -m fbimpact …` is the program."""

import os
import subprocess
import sys

from .program import FileError, find_program


def main() -> int:
    """Runs the program in place of this process where that can be done."""
    try:
        command = [find_program(), *sys.argv[1:]]
    except FileError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_code
    if os.name == "nt":
        return subprocess.run(command).returncode
    os.execv(command[0], command)


if __name__ == "__main__":
    sys.exit(main())
