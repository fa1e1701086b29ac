"""Controller, simulated car, race and time-optimal lap.

Shapes stand behind the arrays, units in square brackets. A state is
``[v_x, v_y, omega_z, e_psi, s, e_y]`` [m/s, m/s, rad/s, rad, m, m], an input ``[a, delta]``
[m/s^2, rad], a global state ``[x, y, psi, v_x, v_y, omega_z]`` [m, m, rad, m/s, m/s, rad/s].
"""

from collections.abc import Callable
from os import PathLike
from typing import Any, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Floats: TypeAlias = NDArray[np.float64]
_Path: TypeAlias = str | PathLike[str]
_CarLike: TypeAlias = Car | _Path
_TrackLike: TypeAlias = Track | _Path
_ConfigLike: TypeAlias = Config | dict[str, Any]
_Changes: TypeAlias = dict[str, float] | str

__all__ = [
    "Campaign",
    "CampaignError",
    "CampaignTable",
    "Car",
    "CarError",
    "Config",
    "ConfigError",
    "Controller",
    "ControllerState",
    "DataError",
    "Error",
    "FailureRule",
    "LapResult",
    "LearnedModel",
    "Optimum",
    "OptimumError",
    "Plan",
    "Plant",
    "PlantState",
    "Race",
    "RaceError",
    "SafeSet",
    "Status",
    "Track",
    "TrackError",
    "__version__",
    "optimum",
    "race",
]

__version__: str

class Error(ValueError):
    """Something was refused; the message names what was found and what was expected."""

class CampaignError(Error):
    """A campaign or its table that is wrong."""

class CarError(Error):
    """A car that does not exist or is wrong."""

class TrackError(Error):
    """A track that does not exist or is wrong."""

class ConfigError(Error):
    """A key or value of a configuration that is not allowed, or one that does not fit the track."""

class DataError(Error):
    """Learned data that are damaged or of another car, track or configuration."""

class RaceError(Error):
    """A race that cannot begin or go on."""

class OptimumError(Error):
    """No time-optimal lap was found."""

@final
class Track:
    """A closed race track: a centre line of length L with its curvature, and both edges.

    Progress s [m] may lie in any lap. Methods take a number or an array of any shape.
    Tracks are equal if their geometry is; they can be pickled.
    """

    def __new__(cls, name: _Path) -> Track:
        """A track that ships with the package, or a file in any format that ``lmpc`` reads.

        Points of a file are smoothed as their noise asks for; see `changes`.

        Raises:
            TrackError: there is no such track, or the file is wrong.
        """

    @staticmethod
    def names() -> list[str]:
        """Names of the tracks that ship with the package."""

    @staticmethod
    def from_text(text: str, name: str = "track", smooth: float | None = None) -> Track:
        """The track of a file's text. `smooth`: as in `from_points`."""

    @staticmethod
    def from_points(
        x: ArrayLike,
        y: ArrayLike,
        width_left: ArrayLike,
        width_right: ArrayLike,
        name: str = "track",
        smooth: float | None = 0.0,
    ) -> Track:
        """A track through points of its centre line in the order of driving, the last one step
        before the first.

        Args:
            x: positions (n,) [m].
            y: positions (n,) [m].
            width_left: distances to the left edge, (n,) or one number [m].
            width_right: distances to the right edge, (n,) or one number [m].
            name: name in reports.
            smooth: distance by which smoothing moves the points, in the root mean square [m];
                0 for a line exactly through them, `None` for what their noise asks for.
        """

    @staticmethod
    def from_segments(
        lengths: ArrayLike,
        curvatures: ArrayLike,
        width_left: float,
        width_right: float,
        name: str = "track",
    ) -> Track:
        """A track of straights and arcs that starts at (0, 0) along +x and must close.

        Args:
            lengths: of the segments (n,) [m].
            curvatures: of the segments, positive to the left, 0 for a straight (n,) [1/m].
            width_left: distance to the left edge [m].
            width_right: distance to the right edge [m].
            name: name in reports.
        """

    @staticmethod
    def random(seed: int, car: Car) -> Track:
        """A random track at the scale of a car; the same seed gives the same track."""

    @property
    def name(self) -> str:
        """Name of the track."""

    @property
    def length(self) -> float:
        """Length L of the centre line [m]."""

    @property
    def narrowest(self) -> float:
        """Width from edge to edge at the narrowest place [m]."""

    @property
    def max_abs_kappa(self) -> float:
        """Largest curvature of the centre line, without sign [1/m]."""

    @property
    def fingerprint(self) -> int:
        """Hash of geometry and widths, the same on every machine."""

    @property
    def changes(self) -> list[str]:
        """What the import changed of a file's points, in sentences."""

    def wrap(self, s: ArrayLike) -> _Floats:
        """Progress brought into [0, L) [m]."""

    def kappa(self, s: ArrayLike) -> _Floats:
        """Curvature of the centre line, positive to the left [1/m]."""

    def width_left(self, s: ArrayLike) -> _Floats:
        """Distance from the centre line to the left edge [m]."""

    def width_right(self, s: ArrayLike) -> _Floats:
        """Distance from the centre line to the right edge [m]."""

    def heading(self, s: ArrayLike) -> _Floats:
        """Heading of the centre line, continuous along the lap [rad]."""

    def position(self, s: ArrayLike, e_y: float = 0.0) -> _Floats:
        """Places `e_y` [m] to the left of the centre line: x, y as the last axis (..., 2) [m]."""

    def left_edge(self, s: ArrayLike) -> _Floats:
        """Places of the left edge (..., 2) [m]."""

    def right_edge(self, s: ArrayLike) -> _Floats:
        """Places of the right edge (..., 2) [m]."""

    def to_global(self, x: ArrayLike) -> _Floats:
        """The global state (6,) of a state (6,)."""

    def to_frenet(self, g: ArrayLike, hint: float | None = None) -> _Floats:
        """The state (6,) of a global state (6,). `hint`: the s of the step before [m]."""

    def problems_for(self, car: Car) -> list[str]:
        """Why a car does not get round, in sentences; empty if it does."""

    def to_toml(self) -> str:
        """The track as a file of ours; reading it gives the same track to the last bit."""

    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class Car:
    """All parameters of a car, by the keys of its file. Cars can be compared and pickled."""

    def __new__(cls, name: _Path) -> Car:
        """A car that ships with the package, or a car file.

        Raises:
            CarError: there is no such car, or the file is wrong.
        """

    @staticmethod
    def names() -> list[str]:
        """Names of the cars that ship with the package."""

    @staticmethod
    def from_toml(text: str) -> Car:
        """The car of a file's text."""

    def to_toml(self) -> str:
        """The text of a car file with every key, each with unit and meaning."""

    def with_keys(self, keys: dict[str, Any]) -> Car:
        """This car with other values, e.g. ``{"mass_kg": 3.0, "tyre_front.mu": 0.8}``."""

    def with_mu(self, mu: float) -> Car:
        """This car with the same friction coefficient on both axles [-]."""

    def nominal(self, mu: float | None = None) -> Car:
        """The car a controller believes in: with the friction `mu` [-], or by default with the
        paper's 1.2 for the car `barc` and its own for every other, as in ``lmpc race``."""

    @property
    def name(self) -> str:
        """Name in reports."""

    @property
    def mass(self) -> float:
        """Mass [kg]."""

    @property
    def wheelbase(self) -> float:
        """Distance between the axles [m]."""

    @property
    def size(self) -> tuple[float, float]:
        """Length and width of the body [m]."""

    @property
    def mu(self) -> tuple[float, float]:
        """Friction coefficient of front and rear axle [-]."""

    @property
    def limits(self) -> tuple[float, float, float]:
        """Strongest braking (negative) and driving command [m/s^2], steering stop [rad]."""

    @property
    def fingerprint(self) -> int:
        """Hash of every number, the same on every machine."""

    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class Config:
    """What is set of a configuration. The rest follows from the preset, the car and the track."""

    def __new__(
        cls,
        preset: str | None = None,
        file: _Path | None = None,
        keys: dict[str, Any] | None = None,
    ) -> Config:
        """A file, over it a preset (``race`` or ``paper``), over it keys such as
        ``{"horizon.steps": 12}``.

        Raises:
            ConfigError: a key or a value is not allowed.
        """

    def set(self, key: str, value: Any) -> Config:
        """Sets one key, e.g. ``set("regression.mode", "full")``; returns the configuration."""

    def values(self, car: _CarLike, track: _TrackLike) -> dict[str, Any]:
        """Every key with its value for a controller that believes in this car, on this track."""

    def origins(self, car: _CarLike, track: _TrackLike) -> dict[str, str]:
        """Every key with where its value comes from."""

    def copy(self) -> Config:
        """A copy that changes on its own."""

@final
class LapResult:
    """A finished lap."""

    @property
    def lap(self) -> int:
        """Number of the lap, from 1."""

    @property
    def kind(self) -> str:
        """``warmup``, ``learning`` or ``driven``."""

    @property
    def lap_time(self) -> float:
        """Time between the interpolated crossings of the line [s]."""

    @property
    def valid(self) -> bool:
        """Whether the whole lap was inside the track, with complete data."""

@final
class Status:
    """What a step did, why, and how far it can be trusted."""

    @property
    def action(self) -> str:
        """``warm_up``, ``learned``, ``shifted_plan``, ``tracking``, ``braking`` or
        ``recovering``."""

    @property
    def reason(self) -> str:
        """Why, if not the normal course; else empty."""

    @property
    def solve(self) -> str:
        """How the solver ended: ``not_run``, ``solved``, ``almost_solved``, ..."""

    @property
    def solver(self) -> str:
        """``structured`` or ``clarabel``; empty if no problem was solved."""

    @property
    def iterations(self) -> int:
        """Iterations of the solver."""

    @property
    def lap(self) -> int:
        """Number of the current lap, from 1."""

    @property
    def state(self) -> _Floats:
        """State that the step used (6,)."""

    @property
    def cost(self) -> float:
        """Optimal cost of the FHOCP [steps]."""

    @property
    def cost_to_go(self) -> float:
        """Part of it: cost-to-go of the terminal state, J' lambda [steps]."""

    @property
    def lane_slack(self) -> float:
        """Largest lane slack along the plan [m]."""

    @property
    def front_slip_slack(self) -> float:
        """Largest front slip-guard slack along the plan [rad]."""

    @property
    def rear_slip_slack(self) -> float:
        """Largest rear slip-guard slack along the plan [rad]."""

    @property
    def speed_slack(self) -> float:
        """Largest speed-cap slack along the plan [m/s]."""

    @property
    def terminal_slack_cost(self) -> float:
        """Part of `cost`: penalty of the terminal slack [steps]."""

    @property
    def data_support_min(self) -> float:
        """Sum of the kernel weights at the worst supported point of the horizon; 0: the nominal
        model stands alone there."""

    @property
    def data_support_mean(self) -> float:
        """Its mean over the horizon."""

    @property
    def clipped(self) -> bool:
        """Whether the input was cut to the car's limits."""

    @property
    def finished(self) -> LapResult | None:
        """The lap that this measurement finished."""

@final
class Plan:
    """The plan of a step."""

    @property
    def x(self) -> _Floats:
        """States (N + 1, 6); (0, 6) before learning begins."""

    @property
    def u(self) -> _Floats:
        """Inputs (N, 2)."""

@final
class SafeSet:
    """The safe set of a step's problem: recorded states near the end of the horizon."""

    @property
    def points(self) -> _Floats:
        """States (n, 6)."""

    @property
    def cost_to_go(self) -> _Floats:
        """Periods each of them took to the line, least first subtracted (n,) [steps]."""

    @property
    def weights(self) -> _Floats:
        """Weights lambda in the solution (n,)."""

@final
class LearnedModel:
    """The model around a point, x_plus = A x + B u + C, in its parts: each A (6, 6), B (6, 2),
    C (6,)."""

    @property
    def nominal(self) -> tuple[_Floats, _Floats, _Floats]:
        """Linearised nominal model A^f, B^f, C^f."""

    @property
    def error(self) -> tuple[_Floats, _Floats, _Floats]:
        """Regressed error A^e, B^e, C^e."""

    @property
    def sum(self) -> tuple[_Floats, _Floats, _Floats]:
        """Their sum."""

    @property
    def support(self) -> float:
        """Sum of the kernel weights behind the error."""

@final
class ControllerState:
    """All that changes while a controller runs; taking it is cheap whatever was learned."""

@final
class Controller:
    """The learning controller: one step per period. It has no clock and no files of its own.

    Steps release the interpreter's lock. A controller serves one thread at a time.
    """

    def __new__(
        cls, car: _CarLike, track: _TrackLike, config: _ConfigLike | None = None
    ) -> Controller:
        """A controller that believes in this car (see `Car.nominal`) and knows nothing else.

        Raises:
            CarError, TrackError, ConfigError: the arguments are wrong or do not fit together.
        """

    def step(
        self, x: ArrayLike, time: float | None = None, applied: ArrayLike | None = None
    ) -> tuple[_Floats, Status]:
        """Reads a measured state and returns the input for the coming period; never fails on
        what was measured.

        Args:
            x: state (6,), s in [0, L). A float64 array is read where it lies.
            time: time of the measurement; by default one period after the step before [s].
            applied: input (2,) that really acted since then, where the car reports it.

        Returns:
            Input (2,), finite and inside the car's limits, and what was done.
        """

    def step_global(
        self, g: ArrayLike, time: float | None = None, applied: ArrayLike | None = None
    ) -> tuple[_Floats, Status]:
        """`step` with a global state (6,), which is projected onto the track."""

    def prepare(self) -> None:
        """Does the part of the next step that needs no measurement. Without it the next step does
        it, with the same result."""

    def set_speed_cap(self, cap: float) -> None:
        """Speed that plans keep to from the next step on; 0 takes it away [m/s]."""

    def finish_learning(self) -> None:
        """Learns from all closed laps now; otherwise in pieces over the coming steps."""

    @property
    def learning_pending(self) -> bool:
        """Whether something of the closed laps is still to be learned."""

    @property
    def period(self) -> float:
        """Control period [s]."""

    @property
    def warm_up_speed(self) -> float:
        """Speed of the initial laps; races begin with it [m/s]."""

    @property
    def track(self) -> Track:
        """The track."""

    @property
    def grip(self) -> tuple[float, float]:
        """Fitted factors on front and rear grip [-]."""

    @property
    def delay(self) -> float:
        """Time from a command to the beginning of its effect, in force [s]."""

    @property
    def lag(self) -> float:
        """Time constant of the actuators in force [s]."""

    @property
    def laps(self) -> list[dict[str, Any]]:
        """Closed laps, oldest first: ``lap``, ``kind``, ``lap_time`` [s], ``valid``, and the
        samples ``time`` (n,) [s], ``x`` (n, 6), ``u`` (n, 2)."""

    @property
    def plan(self) -> Plan:
        """The plan of the last step."""

    @property
    def safe_set(self) -> SafeSet:
        """The safe set of the last step."""

    def learned_model(self, x: ArrayLike, u: ArrayLike) -> LearnedModel:
        """The learned model around a state (6,) and an input (2,)."""

    def save(self) -> bytes:
        """What was learned, with the fingerprints of car, track and configuration."""

    def load(self, data: bytes) -> None:
        """Starts from saved data.

        Raises:
            DataError: damaged, or of another car, track or configuration; nothing is changed.
        """

    def save_file(self, path: _Path) -> None:
        """Writes what was learned; an earlier file stays as ``.bak``."""

    def load_file(self, path: _Path) -> None:
        """`load` from a file."""

    @property
    def state(self) -> ControllerState:
        """All that changes, to go back to with `resume`."""

    def resume(self, state: ControllerState) -> None:
        """Goes on from a state of a controller of the same car, track and configuration."""

@final
class PlantState:
    """All that changes while a plant runs."""

@final
class Plant:
    """The simulated car: own integrator, slow and late actuators, noisy sensors."""

    def __new__(
        cls,
        car: _CarLike,
        track: _TrackLike,
        x: ArrayLike | None = None,
        changes: _Changes | None = None,
        seed: int = 0,
        substep: float | None = None,
    ) -> Plant:
        """A car on a track.

        Args:
            car: the true car.
            track: the track.
            x: state (6,) at the start; by default at rest on the line.
            changes: as in ``lmpc race --plant``, e.g. ``{"mu": 0.7, "delay": 0.1}``.
            seed: of sensor noise and disturbances.
            substep: longest step of the integration [s]; 0.01 by default.
        """

    def apply(self, u: ArrayLike, dt: float) -> None:
        """Drives with an input (2,) for `dt` [s]."""

    def measure(self) -> _Floats:
        """What the sensors say now: a state (6,), s in [0, L). Noise is drawn with each call."""

    @property
    def truth(self) -> _Floats:
        """The true state (6,), s in [0, L)."""

    @property
    def pose(self) -> _Floats:
        """The true global state (6,)."""

    @property
    def applied(self) -> _Floats:
        """The input (2,) that acted last, after delay, lag and limits."""

    @property
    def utilisation(self) -> tuple[float, float]:
        """Share of each axle's peak force in use, front and rear [-]."""

    @property
    def overhang(self) -> float:
        """How far the body is beyond an edge; negative inside [m]."""

    @property
    def time(self) -> float:
        """Time since the start [s]."""

    @property
    def progress(self) -> float:
        """Way along the track, growing over the laps [m]."""

    @property
    def lap(self) -> int:
        """Times that the line was crossed."""

    @property
    def car(self) -> Car:
        """The true car, with the changes."""

    @property
    def track(self) -> Track:
        """The track."""

    def reset(self, x: ArrayLike | None = None, seed: int | None = None) -> None:
        """Back to time 0 in a state (6,), with fresh actuators and the noise of `seed` or of the
        seed before."""

    @property
    def state(self) -> PlantState:
        """All that changes, to go back to with `restore`."""

    def restore(self, state: PlantState) -> None:
        """Goes on from a state of a plant with the same parameters."""

@final
class FailureRule:
    """When a run counts as failed, as in ``lmpc race``."""

    def __new__(
        cls,
        car: _CarLike,
        track: _TrackLike,
        config: _ConfigLike | None = None,
        body: bool | None = None,
    ) -> FailureRule:
        """The rule for a car on a track. `body`: whether its whole body has to stay inside, or
        only its centre of gravity; by default as the preset has it."""

    def broken(self, x: ArrayLike, lap_time: float) -> str | None:
        """Why a true state (6,), `lap_time` [s] after the line, ends the run: ``off_track``,
        ``spin``, ``wrong_way``, ``standstill``, ``no_lap``, ``not_finite``; else `None`."""

    def beyond(self, x: ArrayLike) -> float:
        """How far what has to stay inside is beyond an edge; negative inside [m]."""

    @property
    def lap_time_limit(self) -> float:
        """Longest time a lap may take [s]."""

@final
class Campaign:
    """A campaign from a file, as ``lmpc study`` runs it.

    Each of its runs is a function of its row: whoever drives it gets the same fields, to the last
    bit. `racing_lmpc.engines.study` drives all of them on a cluster.
    """

    def __new__(cls, path: _Path) -> Campaign:
        """Reads the file of a campaign.

        Raises:
            CampaignError: the file, or a file it names, is missing or wrong.
        """

    @property
    def title(self) -> str:
        """Heading."""

    @property
    def axes(self) -> list[str]:
        """Keys of the axes."""

    @property
    def columns(self) -> list[str]:
        """Names of the columns of ``runs.csv``."""

    @property
    def runs(self) -> list[int]:
        """Numbers of the runs."""

    def settings(self, run: int) -> str:
        """Fingerprint of everything that is set in a run but the seed, and of the version."""

    def drive(self, run: int) -> list[str]:
        """Drives a run and returns its fields in the order of `columns`. Releases the interpreter's
        lock. A car that fails is a result."""

    def open(self, folder: _Path, fresh: bool = False) -> CampaignTable:
        """Opens the table in a folder, which keeps the runs that it has; with `fresh` it begins a new
        one. One folder takes one program at a time.

        Raises:
            CampaignError: the table has other columns or a line that is no row, another program
                writes to it, or it cannot be written.
        """

@final
class CampaignTable:
    """The table of a campaign on disk: a line a run, written as soon as it is added."""

    @property
    def missing(self) -> list[int]:
        """Numbers of the runs that are not in it."""

    def add(self, fields: list[str]) -> None:
        """Adds the fields of a run. A run that is in it already, because two workers drove it, is
        left out.

        Raises:
            CampaignError: the fields are not those of a run of this campaign, or the table is closed.
        """

    def close(self) -> None:
        """Puts the runs into the order of their numbers and lets the folder go."""

@final
class Race:
    """A race that has been driven."""

    @property
    def laps(self) -> dict[str, NDArray[Any]]:
        """The columns of ``laps.csv``, an array (laps,) each."""

    @property
    def trajectory(self) -> dict[str, NDArray[Any]]:
        """The columns of ``trajectory.csv``, an array (steps,) each; units end the names."""

    @property
    def x(self) -> _Floats:
        """True states (steps, 6)."""

    @property
    def u(self) -> _Floats:
        """Inputs (steps, 2)."""

    @property
    def step_times(self) -> dict[str, _Floats]:
        """Times of the steps, whole (``step``) and by phase, (steps,) each [s]."""

    @property
    def best_lap(self) -> float | None:
        """Fastest valid learned lap [s]."""

    @property
    def failure(self) -> dict[str, Any] | None:
        """Why it ended early: ``reason``, ``iteration``, ``time`` [s], state ``x`` (6,),
        ``beyond`` [m], ``message``."""

    @property
    def incidents(self) -> list[dict[str, Any]]:
        """Failures from which the car drove back, with `recover`."""

    @property
    def learned(self) -> bytes:
        """What was learned, for `Controller.load` or another race."""

    def save_file(self, path: _Path) -> None:
        """Writes what was learned; an earlier file stays as ``.bak``."""

    @property
    def grip(self) -> tuple[float, float]:
        """Fitted factors on front and rear grip [-]."""

    @property
    def delay(self) -> float:
        """Time from a command to the beginning of its effect, given or found [s]."""

    @property
    def lag(self) -> float:
        """Time constant of the actuators, given or found [s]."""

    @property
    def track(self) -> Track:
        """The track."""

    def write(self, folder: _Path) -> None:
        """Writes ``laps.csv``, ``trajectory.csv`` and ``timings.csv`` as ``lmpc race`` does."""

def race(
    car: _CarLike | None = None,
    track: _TrackLike | None = None,
    config: _ConfigLike | None = None,
    *,
    laps: int = 20,
    seed: int = 0,
    plant: _Changes | None = None,
    nominal_mu: float | None = None,
    body: bool | None = None,
    recover: bool = False,
    learned: bytes | _Path | None = None,
    on_lap: Callable[[dict[str, Any]], object] | None = None,
) -> Race:
    """Races the simulated car: ``lmpc race`` with the same options, to the same bits.

    Releases the interpreter's lock, so that threads race side by side. Ctrl-C ends it at the end
    of a lap.

    Args:
        car: ``barc`` by default.
        track: ``l`` by default.
        config: a `Config`, or keys such as ``{"horizon.steps": 12}``.
        laps: laps to drive after the warm-up laps.
        seed: of the warm-up laps, the sensor noise and the disturbances.
        plant: changes of the simulated car, e.g. ``{"mu": 0.7, "delay": 0.1}``.
        nominal_mu: friction the controller believes in; see `Car.nominal` [-].
        body: whether the whole body has to stay inside, or only the centre of gravity.
        recover: whether the car drives back after a failure and races on.
        learned: learned data to start from, as bytes or as a file.
        on_lap: called with each lap as a dictionary as it ends; what it raises ends the race.

    Raises:
        CarError, TrackError, ConfigError, DataError, RaceError: it cannot begin. A car that fails
            under way is no exception: see `Race.failure`.
    """

@final
class Optimum:
    """A time-optimal lap: what no driver and no controller can beat."""

    @property
    def lap_time(self) -> float:
        """Lap time [s]."""

    @property
    def margin(self) -> float:
        """Distance that the centre of gravity keeps from either edge [m]."""

    @property
    def time(self) -> _Floats:
        """Time since the line at each point (n,) [s]."""

    @property
    def x(self) -> _Floats:
        """States (n, 6); the first is repeated at the end, one lap later."""

    @property
    def u(self) -> _Floats:
        """Inputs that act (n, 2)."""

    @property
    def quality(self) -> dict[str, Any]:
        """How good it is: deviation of the plant, optimality, mesh, starts."""

def optimum(
    car: _CarLike, track: _TrackLike, margin: float | None = None, starts: int = 3
) -> Optimum:
    """Finds the time-optimal lap of a car on a track, confirmed by the simulated car.

    Releases the interpreter's lock.

    Args:
        car: the car.
        track: the track.
        margin: distance from the edges [m]; by default that of a race.
        starts: starts that are tried, 1 to 4.

    Raises:
        OptimumError: no lap was found.
    """
