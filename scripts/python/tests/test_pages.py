"""The page with every argument has every argument, in the order and with the defaults of the package."""

from __future__ import annotations

import inspect
import pathlib
import re

import pytest

import fbimpact

PAGE = (pathlib.Path(__file__).resolve().parents[3] / "docs/python_api.md").read_text()


def heading(name: str, function: object) -> str:
    """A call as the page writes it."""
    parts: list[str] = []
    for parameter in inspect.signature(function).parameters.values():  # type: ignore[arg-type]
        if parameter.name == "self":
            continue
        if parameter.kind is parameter.KEYWORD_ONLY and "*" not in parts:
            parts.append("*")
        is_needed = parameter.default is parameter.empty
        default = '"peak"' if parameter.default == "peak" else repr(parameter.default)
        parts.append(parameter.name if is_needed else f"{parameter.name}={default}")
    return f"`{name}({', '.join(parts)})`"


def test_functions_stand_on_the_page_with_all_their_arguments() -> None:
    functions = {name: getattr(fbimpact, name) for name in fbimpact.__all__ if inspect.isfunction(getattr(fbimpact, name))}
    methods = {
        name: member
        for kind in (fbimpact.Result, fbimpact.Sweep, fbimpact.SweepRun)
        for name, member in vars(kind).items()
        if inspect.isfunction(member) and not name.startswith("_")
    }
    missing = [call for name, f in [*functions.items(), *methods.items()] if (call := heading(name, f)) not in PAGE]
    assert not missing
    arguments = {p for f in [*functions.values(), *methods.values()] for p in inspect.signature(f).parameters} - {"self"}
    assert not [a for a in arguments if not re.search(rf"`{a}`|`{a}[=,)]|[(, ]{a}[=,)]", PAGE)]


def test_figures_stand_on_the_page() -> None:
    figures = pytest.importorskip("fbimpact.figures")
    drawn = {n: f for n, f in vars(figures).items() if inspect.isfunction(f) and f.__module__ == figures.__name__ and not n.startswith("_")}
    assert not [call for name, f in drawn.items() if (call := heading(name, f)) not in PAGE]


def test_classes_and_their_properties_stand_on_the_page() -> None:
    classes = [getattr(fbimpact, name) for name in fbimpact.__all__ if inspect.isclass(getattr(fbimpact, name))]
    assert not [c.__name__ for c in classes if f"`{c.__name__}`" not in PAGE and f"`{c.__name__}(" not in PAGE]
    properties = {n for c in classes for n, m in vars(c).items() if isinstance(m, property)}
    assert not [name for name in properties if f"`{name}`" not in PAGE]
