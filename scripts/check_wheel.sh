#!/usr/bin/env bash
# Checks the wheel of a built program in a fresh virtual environment that is not activated: it installs without a network, `fbimpact` runs a
# template, and the Python package finds the wheel's own program and no other. Nothing is loaded from a network: packages that reading results
# needs are those of the Python that makes the environment; where it has not got them, that is skipped with a word.
#
#   scripts/check_wheel.sh [PROGRAM]
set -euo pipefail
cd "$(dirname "$0")/.."

PROGRAM=$(realpath "${1:-target/release/fbimpact}")
PYTHON=${PYTHON:-python3}
export PYTHONDONTWRITEBYTECODE=1 PIP_DISABLE_PIP_VERSION_CHECK=1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
before=$(git status --porcelain --ignored 2>/dev/null || true)

if ! "$PYTHON" -m venv "$folder/environment" 2>/dev/null; then
    echo "wheel: not checked, $PYTHON makes no virtual environment"
    exit 0
fi
pip() { "$folder/environment/bin/python" -m pip -q "$@"; }

wheel=$("$PYTHON" scripts/package_wheel.py "$folder/wheels" --program "$PROGRAM")
[[ $wheel == *-py3-none-* ]]
# The same from `pip install .`: pip calls the build backend, which is given the program.
FBIMPACT_PROGRAM=$PROGRAM pip wheel --no-deps --no-build-isolation -w "$folder/built" .
cmp "$wheel" "$folder/built/$(basename "$wheel")"
pip install --no-deps --no-index "$wheel"
if [ "$(git status --porcelain --ignored 2>/dev/null || true)" != "$before" ]; then
    echo "wheel: building has written into the sources" >&2
    exit 1
fi

cd "$folder"
unset FBIMPACT PYTHONPATH
environment/bin/fbimpact new first
environment/bin/fbimpact run -q first.toml
test -s first.h5
# A program of the same name on the path is not the one of the environment; program.py needs Python alone.
mkdir other
printf '#!/bin/sh\nexit 9\n' > other/fbimpact
chmod +x other/fbimpact
module=$(echo environment/lib/python*/site-packages/fbimpact/program.py)
cat > find.py <<'PROGRAM_PY'
import importlib.util, sys
spec = importlib.util.spec_from_file_location("program", sys.argv[1])
sys.modules["program"] = program = importlib.util.module_from_spec(spec)
spec.loader.exec_module(program)
print(program.find_program())
PROGRAM_PY
found=$(PATH=$folder/other:$PATH environment/bin/python find.py "$module")
[ "$found" = "$(realpath environment/bin)/fbimpact" ] || { echo "wheel: the package finds $found" >&2; exit 1; }

# Packages of the Python that made the environment, behind those of the environment.
"$PYTHON" -c "import sysconfig; print(sysconfig.get_path('purelib'))" > "$(dirname "$(dirname "$module")")/others.pth"
if environment/bin/python -c "import h5py, numpy, tomli_w, xarray" 2>/dev/null; then
    PATH=$folder/other:$PATH environment/bin/python -W error::UserWarning - <<'PYTHON_END'
import fbimpact

result = fbimpact.run("first.toml", output="again.h5")
assert result.status == "complete" and len(result.impacts["peak_force"]) == 1, result.status
PYTHON_END
    PATH=$folder/other:$PATH environment/bin/python -m fbimpact --version > version
    grep -q '^fbimpact ' version
    echo "wheel: $(basename "$wheel") installs, runs and is read"
else
    echo "wheel: $(basename "$wheel") installs and runs; reading results is skipped, $PYTHON has not h5py, numpy, tomli_w and xarray"
fi
