"""Tunes weights of the controller against the best lap of a car with Optuna; a car that fails, or
comes closer to an edge than a margin, breaks a constraint.

    python python/examples/tune.py --car barc --track l --trials 40

Needs ``optuna``. The same seed and number of trials give the same result.
"""

import argparse

import optuna

import racing_lmpc as lmpc

#: Range of each weight, as factors on the value that follows from the car.
WEIGHTS = ("cost.control_rate", "cost.lane_linear", "cost.slip")


def margin_kept(race):
    """How far the body stayed from the edges at worst in learned laps; negative beyond one [m]."""
    overhang = race.trajectory["overhang_m"]
    return -float(overhang.max())


def study(car, track, trials, laps=8, margin=0.005, seed=0):
    """The Optuna study of a car on a track."""
    derived = lmpc.Config().values(lmpc.Car(car).nominal(), lmpc.Track(track))
    weights = [name for name in WEIGHTS if derived.get(name)]

    def objective(trial):
        keys = {name: derived[name] * trial.suggest_float(name, 0.2, 5.0, log=True) for name in weights}
        race = lmpc.race(car, track, keys, laps=laps, seed=seed)
        # Above 0: the constraint is broken.
        failed = 1.0 if race.failure or race.best_lap is None else 0.0
        trial.set_user_attr("constraints", [failed, margin - margin_kept(race)])
        return 1e3 if failed else race.best_lap

    sampler = optuna.samplers.TPESampler(
        seed=seed, constraints_func=lambda trial: trial.user_attrs["constraints"]
    )
    tuned = optuna.create_study(sampler=sampler)
    # The values that follow from the car come first: a result is never worse than them.
    tuned.enqueue_trial(dict.fromkeys(weights, 1.0))
    tuned.optimize(objective, n_trials=trials)
    return tuned


def feasible(tuned):
    """Trials that break no constraint, the fastest first."""
    kept = [t for t in tuned.trials if all(c <= 0 for c in t.user_attrs.get("constraints", [1]))]
    return sorted(kept, key=lambda trial: trial.value)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--car", default="barc")
    parser.add_argument("--track", default="l")
    parser.add_argument("--trials", type=int, default=40)
    parser.add_argument("--laps", type=int, default=8)
    options = parser.parse_args()
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    tuned = study(options.car, options.track, options.trials, options.laps)
    kept = feasible(tuned)
    print(f"{len(kept)} of {len(tuned.trials)} trials keep the constraints")
    if not kept:
        raise SystemExit("none keeps the constraints: the derived settings do not, either")
    print(f"as derived: {tuned.trials[0].value:.3f} s, tuned: {kept[0].value:.3f} s with factors")
    for name, factor in kept[0].params.items():
        print(f"  {name} x {factor:.3f}")


if __name__ == "__main__":
    main()
