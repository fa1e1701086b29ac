"""What a step from Python costs more than a native one: the same race driven by both, several times,
the least time of each step compared.

Run it on an otherwise idle machine: ``python python/examples/step_cost.py``.
"""

import time

import numpy as np

import racing_lmpc as lmpc

REPEATS = 9


def from_python():
    """Times of the steps of a race whose loop is in Python [s]."""
    car, track = lmpc.Car("barc"), lmpc.Track("l")
    controller = lmpc.Controller(car.nominal(), track)
    plant = lmpc.Plant(car, track, x=[controller.warm_up_speed, 0, 0, 0, 0, 0])
    times = []
    while len(controller.laps) < 14:
        x = plant.measure()
        begin = time.perf_counter()
        u, status = controller.step(x)
        times.append(time.perf_counter() - begin)
        plant.apply(u, controller.period)
    return np.array(times)


def native():
    """Times of the same steps, measured in Rust around the native call [s]."""
    return lmpc.race("barc", "l", laps=10).step_times["step"]


pairs = [(native(), from_python()) for _ in range(REPEATS)]
count = min(len(times) for pair in pairs for times in pair)
least = [np.min([pair[i][:count] for pair in pairs], axis=0) for i in (0, 1)]
more = 1e6 * (least[1] - least[0])
print(f"{count} steps, least of {REPEATS}: native median {1e6 * np.median(least[0]):.1f} us, "
      f"from Python {np.median(more):+.2f} us (quarter to three quarters "
      f"{np.quantile(more, 0.25):+.2f} to {np.quantile(more, 0.75):+.2f})")
