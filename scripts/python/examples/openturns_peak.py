#!/usr/bin/env python3
"""OpenTURNS tells how scatter of Young's modulus, density and speed becomes scatter of the peak force of an impact.

    openturns_peak.py SCENARIO.toml [RUNS]

A linear model of the logarithms through a Latin hypercube of runs; by Hertz's theory its slopes are 0.4, 0.6 and 1.2.
"""

import math
import pathlib
import sys
import tempfile

import fbimpact
import openturns as ot

KEYS = ["materials.aluminium.youngs_modulus", "materials.aluminium.density", "bodies.ball.velocity[2]"]


def main() -> None:
    scenario = sys.argv[1]
    n = int(sys.argv[2]) if len(sys.argv) > 2 else 12
    # Factors on the values of the scenario, five per cent each.
    factors = ot.JointDistribution([ot.Uniform(0.95, 1.05)] * 3)
    ot.RandomGenerator.SetSeed(0)
    design = ot.LHSExperiment(factors, n).generate()
    values = [72.8e9, 2789.0, -0.1]
    rows = [{key: value * factor for key, value, factor in zip(KEYS, values, row)} for row in design]
    made = fbimpact.sweep(scenario, rows, pathlib.Path(tempfile.mkdtemp()))
    # Runs that failed are left out of the fit.
    fitted = [(row, metric) for row, metric in zip(design, made.metric("max(impacts.peak_force)")) if metric is not None]
    inputs = ot.Sample([[math.log(factor) for factor in row] for row, _ in fitted])
    outputs = ot.Sample([[math.log(float(metric))] for _, metric in fitted])
    model = ot.LinearLeastSquares(inputs, outputs)
    model.run()
    slopes = [model.getLinear()[i, 0] for i in range(3)]
    for key, slope in zip(KEYS, slopes):
        print(f"{key}: {slope:.4f}")
    scatter = sum((slope * 0.05 / 3**0.5) ** 2 for slope in slopes) ** 0.5
    print(f"scatter of the peak force: {100 * scatter:.2f} %")


main()
