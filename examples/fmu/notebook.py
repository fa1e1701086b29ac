# %% [markdown]
# # Learning to race, lap after lap
#
# The controller FMU drives the vehicle FMU through FMPy. Every cell runs as it stands, in an editor
# that knows `# %%` cells, or the file as a whole:
#
#     pip install fmpy matplotlib
#     python examples/fmu/notebook.py
#
# `make fmu` writes the FMUs to out/fmu; the figure goes there too.

# %%
import sys
from pathlib import Path

here = Path(__file__).resolve().parent if "__file__" in globals() else Path("examples/fmu").resolve()
sys.path.insert(0, str(here))
fmus = here.parents[1] / "out/fmu"

import matplotlib  # noqa: E402

if "ipykernel" not in sys.modules:
    matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from race_fmpy import Fmu, race  # noqa: E402

# %% [markdown]
# ## Two FMUs, one parameter each
#
# The controller believes in a grip of 1.2; the car has 0.9. What it does not know it learns.

# %%
controller = Fmu(fmus / "fmi3/lmpc-controller.fmu", **{"param.nominal_mu": 1.2})
vehicle = Fmu(fmus / "fmi3/lmpc-vehicle.fmu")

# %% [markdown]
# ## Twelve laps: four initial ones at walking pace, then eight learned ones

# %%
rows, laps = [], []


def keep(k, time, state, command):
    rows.append([time, *state, *command])
    laps.append(controller.get(["lap.finished"])[0])


times = race(controller, vehicle, laps=12, on_step=keep)
for lap, lap_time in enumerate(times, 1):
    print(f"lap {lap}: {lap_time:.3f} s")

# %% [markdown]
# ## Lap times, and the line of the fastest lap, coloured by speed

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5))
left.plot(range(1, len(times) + 1), times, "o-")
left.set(xlabel="lap", ylabel="lap time [s]")
left.grid(alpha=0.3)
fastest = times.index(min(times))
line = [row for row, lap in zip(rows, laps) if lap == fastest]
right.plot([row[7] for row in rows], [row[8] for row in rows], color="0.85", linewidth=0.5)
points = right.scatter([r[7] for r in line], [r[8] for r in line], c=[r[1] for r in line], s=14)
right.set(aspect="equal", xlabel="x [m]", ylabel="y [m]",
          title=f"lap {fastest + 1}: {times[fastest]:.3f} s")
figure.colorbar(points, label="v_x [m/s]")
figure.tight_layout()
figure.savefig(fmus / "laps.png", dpi=120)
print(f"figure: {fmus / 'laps.png'}")
