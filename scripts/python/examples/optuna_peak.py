#!/usr/bin/env python3
"""Optuna looks for the speed at which a ball hits a plane with a given peak force.

    optuna_peak.py SCENARIO.toml FORCE [TRIALS]

Hertz's theory knows the answer: the force grows with the speed to the power of 1.2.
"""

import pathlib
import sys
import tempfile

import fbimpact
import optuna


def main() -> None:
    scenario, wanted = sys.argv[1], float(sys.argv[2])
    trials = int(sys.argv[3]) if len(sys.argv) > 3 else 20
    folder = pathlib.Path(tempfile.mkdtemp())

    def off(trial: optuna.Trial) -> float:
        speed = trial.suggest_float("speed", 0.02, 0.4, log=True)
        try:
            changes = {"bodies.ball.velocity[2]": -speed}
            result = fbimpact.run(scenario, changes, output=folder / f"{trial.number}.h5", threads=1)
        except fbimpact.RunFailed as error:
            raise optuna.TrialPruned(error.message) from error
        return abs(float(result.metric("max(impacts.peak_force)")) - wanted)

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=0, n_startup_trials=8))
    study.optimize(off, n_trials=trials)
    print(f"speed {study.best_params['speed']:.5f} m/s, {study.best_value:.4f} N off {wanted} N after {len(study.trials)} runs")


main()
