#!/usr/bin/env bash
# Checks the package in scripts/python: types, tests, and that it installs. What needs a package that Python does not have is skipped with
# a word; nothing is loaded from a network.
#
#   scripts/check_python.sh [PROGRAM]
set -euo pipefail
cd "$(dirname "$0")/.."

FBIMPACT=$(realpath "${1:-target/release/fbimpact}")
export FBIMPACT PYTHONDONTWRITEBYTECODE=1
PYTHON=${PYTHON:-python3}
has() { "$PYTHON" -c "import importlib.util as u, sys; sys.exit(any(u.find_spec(n) is None for n in sys.argv[1:]))" "$@"; }

# Sampling needs nothing but Python.
"$PYTHON" scripts/python/fbimpact/sampling.py 4 'a=0..1' 'b=1..1e3:log' | grep -q '^a&b='
for name in fbimpact/program.py fbimpact/sweeps.py examples/optuna_peak.py examples/dakota/driver.py; do
    "$PYTHON" -c "import ast, sys; ast.parse(open(sys.argv[1]).read())" "scripts/python/$name"
done

if has mypy numpy xarray; then
    (cd scripts/python && "$PYTHON" -m mypy --cache-dir=/dev/null)
else
    echo "python: types are not checked, mypy, numpy or xarray is not installed"
fi
if has pytest h5py numpy xarray tomli_w; then
    (cd scripts/python && PYTHONPATH=. "$PYTHON" -m pytest -q -p no:cacheprovider -rs)
else
    echo "python: tests are skipped, pytest, h5py, numpy, xarray or tomli_w is not installed"
fi
