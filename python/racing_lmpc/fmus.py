"""Races of any pair of FMUs through FMPy, one by one or as a campaign on an engine.

>>> from racing_lmpc import engines, fmus
>>> pair = fmus.Pair("lmpc-controller.fmu", "their_car.fmu", wires={"vehicle.v_x": "speed"})
>>> rows = fmus.study(pair, {"controller:param.warm_up.laps": [1.0, 2.0]}, engines.processes(2))

Needs ``fmpy`` (``pip install racing-lmpc[fmus]``). Co-simulation FMUs of FMI 2.0 and 3.0; the controller
steps first, then the vehicle with the new command, as in ``lmpc race --vehicle fmu:``.
"""

from __future__ import annotations

import dataclasses
import itertools
import shutil
from collections.abc import Iterator, Sequence
from typing import Any

import racing_lmpc as lmpc

from . import engines


@dataclasses.dataclass(frozen=True)
class Pair:
    """Two FMUs and how they are wired."""

    #: File of the controller.
    controller: str
    #: File of the vehicle.
    vehicle: str
    #: Controller's input: vehicle's output; inputs without one are wired to the output of the same name.
    wires: dict[str, str] = dataclasses.field(default_factory=dict)
    #: Vehicle's input: controller's output; the others likewise.
    commands: dict[str, str] = dataclasses.field(default_factory=dict)
    #: Communication step [s].
    period: float = 0.1
    #: End of a race [s].
    duration: float = 120.0
    #: Outputs of either that are recorded: ``controller:NAME`` or ``vehicle:NAME``.
    record: tuple[str, ...] = ("controller:lap.finished", "controller:lap.last_time")


class _Fmu:
    """One FMU with names instead of value references."""

    def __init__(self, path: str, values: dict[str, float | str]) -> None:
        import fmpy  # type: ignore[import-untyped]
        from fmpy.fmi2 import FMU2Slave  # type: ignore[import-untyped]
        from fmpy.fmi3 import FMU3Slave  # type: ignore[import-untyped]

        self.description = fmpy.read_model_description(path)
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.three = self.description.fmiVersion.startswith("3")
        self.folder = fmpy.extract(path)
        self.fmu = (FMU3Slave if self.three else FMU2Slave)(
            guid=self.description.guid or self.description.instantiationToken,
            unzipDirectory=self.folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=self.description.modelName,
        )
        self.fmu.instantiate(loggingOn=False)
        if not self.three:
            self.fmu.setupExperiment(startTime=0.0)
        for name, value in values.items():
            self.set_parameter(name, value)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def names(self, causality: str) -> list[str]:
        return [
            v.name for v in self.description.modelVariables
            if v.causality == causality and v.type in ("Real", "Float64") and v.name != "time"
        ]

    def reference(self, name: str) -> int:
        if name not in self.variables:
            raise lmpc.Error(f"{self.description.modelName} has no variable {name}")
        return int(self.variables[name].valueReference)

    def set_parameter(self, name: str, value: float | str) -> None:
        reference = self.reference(name)
        kind = self.variables[name].type
        three = {"Real": "Float64", "Integer": "Int32"}.get(kind, kind)
        two = {"Float64": "Real", "Int32": "Integer"}.get(kind, kind)
        getattr(self.fmu, f"set{three if self.three else two}")([reference], [value])

    def get(self, references: list[int]) -> list[float]:
        return list((self.fmu.getFloat64 if self.three else self.fmu.getReal)(references))

    def set(self, references: list[int], values: list[float]) -> None:
        (self.fmu.setFloat64 if self.three else self.fmu.setReal)(references, values)

    def step(self, time: float, period: float) -> None:
        self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=period)

    def close(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


def _wires(to: _Fmu, of: _Fmu, given: dict[str, str]) -> tuple[list[int], list[int]]:
    """References of the inputs of one FMU and of the outputs of the other behind them."""
    outputs = set(of.names("output"))
    pairs = [(name, given.get(name, name)) for name in to.names("input")]
    wired = [(i, o) for i, o in pairs if i in given or o in outputs]
    if not wired:
        raise lmpc.Error(
            f"no input of {to.description.modelName} has an output of its name in "
            f"{of.description.modelName}: name them in `wires` and `commands`"
        )
    return [to.reference(i) for i, _ in wired], [of.reference(o) for _, o in wired]


def race(pair: Pair, values: dict[str, float | str] | None = None) -> dict[str, Any]:
    """Drives one race and returns what is recorded at its end and all lap times.

    Args:
        pair: the FMUs.
        values: parameters of either, ``controller:NAME`` or ``vehicle:NAME``.

    Returns:
        ``values``, the recorded outputs, ``lap_times_s`` where the controller has ``lap.finished`` and
        ``lap.last_time``, and ``failure``, the message of an FMU that refused a step or a value.
    """
    values = values or {}
    own = {
        who: {name.split(":", 1)[1]: value for name, value in values.items() if name.startswith(f"{who}:")}
        for who in ("controller", "vehicle")
    }
    if sum(map(len, own.values())) != len(values):
        raise lmpc.Error(f"found {list(values)}, expected names such as controller:NAME or vehicle:NAME")
    row: dict[str, Any] = {**values, "failure": "", "lap_times_s": []}
    fmus: dict[str, _Fmu] = {}
    try:
        for who in ("controller", "vehicle"):
            fmus[who] = _Fmu(getattr(pair, who), own[who])
        controller, vehicle = fmus["controller"], fmus["vehicle"]
        measured, states = _wires(controller, vehicle, pair.wires)
        inputs, commands = _wires(vehicle, controller, pair.commands)
        counts = {"lap.finished", "lap.last_time"} <= set(controller.variables)
        laps = [controller.reference(n) for n in ("lap.finished", "lap.last_time")] if counts else []
        for k in range(round(pair.duration / pair.period)):
            controller.set(measured, vehicle.get(states))
            controller.step(k * pair.period, pair.period)
            vehicle.set(inputs, controller.get(commands))
            vehicle.step(k * pair.period, pair.period)
            if counts:
                finished, last = controller.get(laps)
                if finished > len(row["lap_times_s"]):
                    row["lap_times_s"].append(last)
        for name in pair.record:
            who, variable = name.split(":", 1)
            row[name] = fmus[who].get([fmus[who].reference(variable)])[0]
    except lmpc.Error:
        raise
    except Exception as error:  # FMPy raises its own for every status of an FMU.
        row["failure"] = f"{type(error).__name__}: {error}"
    finally:
        for fmu in fmus.values():
            try:
                fmu.close()
            except Exception as error:  # One that failed may not end well either.
                row["failure"] = row["failure"] or f"{type(error).__name__}: {error}"
    return row


def _race(job: tuple[int, Pair, dict[str, float | str]]) -> dict[str, Any]:
    return race(job[1], job[2])


def study(
    pair: Pair,
    axes: dict[str, Sequence[float | str]],
    engine: engines.Engine | None = None,
) -> list[dict[str, Any]]:
    """Races over all combinations of parameters, in the order of the last axis first.

    Args:
        pair: the FMUs, at paths that the workers read as well.
        axes: parameter, ``controller:NAME`` or ``vehicle:NAME``: its values.
        engine: of `racing_lmpc.engines`; by default a process for each processor.
    """
    points: Iterator[tuple[float | str, ...]] = itertools.product(*axes.values())
    jobs = [(i, pair, dict(zip(axes, point))) for i, point in enumerate(points)]
    rows = {job[0]: row for job, row in (engine or engines.processes())(_race, jobs)}
    return [rows[i] for i in range(len(jobs))]
