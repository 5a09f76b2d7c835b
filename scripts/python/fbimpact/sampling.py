#!/usr/bin/env python3
"""Values for sweeps: all combinations, and Latin hypercubes.

A Latin hypercube of n samples (McKay, Beckman and Conover, Technometrics 21, 1979) divides the range of every key into n equal parts and
has exactly one sample in each of them: n runs see n values of every key, whatever the number of keys.

As a command it prints the words that `scripts/sweep.sh` takes:

    scripts/sweep.sh SCENARIO.toml FOLDER "$(scripts/python/fbimpact/sampling.py 20 'bodies.ball.velocity[2]=-0.5..-0.1' 'KEY=A..B:log')"

Options: --seed N (0), the same samples for the same seed; --keep N, one of so many hypercubes, the one whose nearest samples are farthest
apart (100). Needs nothing but Python.
"""

from __future__ import annotations

import argparse
import itertools
import math
import random
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

Range = tuple[float, float] | tuple[float, float, str]
"""Low and high end, and `"log"` where the logarithm is divided evenly."""


def full_factorial(values: Mapping[str, Iterable[Any]]) -> list[dict[str, Any]]:
    """All combinations of values of keys."""
    keys = list(values)
    return [dict(zip(keys, row)) for row in itertools.product(*(list(values[key]) for key in keys))]


def latin_hypercube(ranges: Mapping[str, Range], n: int, *, seed: int = 0, keep: int = 100) -> list[dict[str, float]]:
    """n samples of keys, uniform in their ranges; of `keep` random ones the hypercube whose nearest samples are farthest apart.

    The same seed gives the same samples on every machine.
    """
    if n < 1 or keep < 1:
        raise ValueError(f"{n} samples out of {keep} hypercubes: both must be at least 1")
    for key, limits in ranges.items():
        _check(key, limits)
    source = random.Random(seed)
    best: list[list[float]] = []
    best_distance = -1.0
    for _ in range(keep):
        columns = [_stratified(n, source) for _ in ranges]
        rows = [list(row) for row in zip(*columns)]
        distance = _nearest(rows)
        if distance > best_distance:
            best, best_distance = rows, distance
    return [{key: _value(u, limits) for (key, limits), u in zip(ranges.items(), row)} for row in best]


def _check(key: str, limits: Range) -> None:
    low, high, *scale = limits
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ValueError(f"{key}: {low}..{high} is no range, the first end must be less than the second")
    if scale and scale != ["log"]:
        raise ValueError(f"{key}: {scale[0]!r} is no scale, there is 'log'")
    if scale and low <= 0.0:
        raise ValueError(f"{key}: {low}..{high} has no logarithms, both ends must be positive")


def _stratified(n: int, source: random.Random) -> list[float]:
    """One number in each of n equal parts of 0 to 1, in random order."""
    parts = [(i + source.random()) / n for i in range(n)]
    source.shuffle(parts)
    return parts


def _nearest(rows: Sequence[Sequence[float]]) -> float:
    return min((math.dist(a, b) for a, b in itertools.combinations(rows, 2)), default=0.0)


def _value(u: float, limits: Range) -> float:
    low, high = limits[0], limits[1]
    return low * (high / low) ** u if len(limits) == 3 else low + (high - low) * u


def _range_of(text: str) -> tuple[str, Range]:
    number = r"[-+]?\d*\.?\d+(?:[eE][-+]?\d+)?"
    match = re.fullmatch(rf"(.+?)=({number})\.\.({number})(?::(\w+))?", text)
    if match is None:
        raise ValueError(f"{text!r}: must be KEY=LOW..HIGH or KEY=LOW..HIGH:log")
    key, low, high, scale = match.groups()
    return key, (float(low), float(high), scale) if scale else (float(low), float(high))


def _main() -> None:
    parser = argparse.ArgumentParser(description="Latin hypercube for scripts/sweep.sh")
    parser.add_argument("samples", type=int)
    parser.add_argument("ranges", nargs="+", metavar="KEY=LOW..HIGH[:log]")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=int, default=100)
    given = parser.parse_args()
    try:
        ranges = dict(_range_of(text) for text in given.ranges)
        rows = latin_hypercube(ranges, given.samples, seed=given.seed, keep=given.keep)
    except ValueError as error:
        sys.exit(f"sampling.py: {error}")
    values = " ".join("&".join(f"{x:.12g}" for x in row.values()) for row in rows)
    print(f"{'&'.join(ranges)}={values}")


if __name__ == "__main__":
    _main()
