"""The notebooks run from the first cell to the last, and what they compute is right."""

from __future__ import annotations

import json
import pathlib

import pytest

NOTEBOOKS = pathlib.Path(__file__).resolve().parents[1] / "examples/notebooks"


def names_after(notebook: str, folder: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, object]:
    """Runs all cells in `folder`; the names that they leave."""
    pytest.importorskip("matplotlib").use("Agg")
    monkeypatch.chdir(folder)
    names: dict[str, object] = {"__name__": "__main__"}
    for cell in json.loads((NOTEBOOKS / notebook).read_text())["cells"]:
        if cell["cell_type"] == "code":
            assert not cell["outputs"], "notebooks are kept without outputs"
            exec("".join(cell["source"]), names)
    return names


def test_first_impact(tmp_path, monkeypatch):
    names = names_after("first_impact.ipynb", tmp_path, monkeypatch)
    # A ball is stiffer than a half space by about a contact radius over its own (docs/verification.md).
    assert abs(names["peak"] / names["hertz"] - 1) < 0.02


def test_sweep(tmp_path, monkeypatch):
    names = names_after("sweep.ipynb", tmp_path, monkeypatch)
    assert not names["made"].failed
    assert all(abs(exponent - 1.2) < 0.01 for exponent in names["exponents"].values())
