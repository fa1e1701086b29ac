"""The simulated car as a Gymnasium environment, and the controller as an agent in it.

>>> import gymnasium
>>> import racing_lmpc.gym
>>> env = gymnasium.make("RacingLMPC-v0", car="barc", track="l")

Needs ``gymnasium`` (``pip install racing-lmpc[gym]``); `RaceEnv.render` needs ``matplotlib``.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

import racing_lmpc as lmpc

#: Times ahead at which the observation has curvature and widths [s].
AHEAD = tuple(np.linspace(0.0, 2.0, 11).tolist())

_FASTEST = 200.0  # m/s
_TURNING = 100.0  # rad/s
_WIDEST = 1000.0  # m


class RaceEnv(gymnasium.Env[NDArray[np.float32], NDArray[Any]]):
    """The simulated car on a track.

    **Action** (2,): acceleration and steering. With ``normalise`` (the default) each in [-1, 1],
    float32: -1 is the car's strongest braking or its right steering stop, 0 is nothing, 1 its
    strongest acceleration or its left stop. Without, ``[a, delta]`` in m/s^2 and rad, float64.

    **Observation** (7 + 3 n,), float32, from what the sensors measure::

        0 v_x [m/s]   1 v_y [m/s]   2 omega_z [rad/s]   3 e_psi [rad]   4 e_y [m]
        5 a [m/s^2]   6 delta [rad]                       the input that acted last
        7 ...         curvature of the centre line [1/m]  at the n places ahead
        7 + n ...     distance to its left edge [m]       at the n places ahead
        7 + 2 n ...   distance to its right edge [m]      at the n places ahead

    The places ahead are those that the car reaches after the times ``ahead`` at its speed, or at the
    speed of the controller's warm-up laps if that is higher. So one policy fits cars of any size.

    **Reward**: progress along the centre line in the step [m], less ``failure_cost`` [m] in a step
    in which the car fails.

    **Episode**: it terminates when the car fails as in ``lmpc race`` (``info["failure"]``), and is
    truncated after ``laps`` laps.

    **Info**: ``x`` the measured state (6,), ``truth`` the true one, ``time`` [s], ``lap`` laps
    finished, ``progress`` [m], ``lap_time`` [s] in the step that finished a lap, else `None`, and
    ``failure``, a word or `None`.

    Args:
        car: a `Car`, a name or a file.
        track: a `Track`, a name or a file.
        config: sets period, warm-up speed and the rule of failure; see `Config`.
        changes: of the simulated car, as in ``lmpc race --plant``.
        nominal_mu: friction from which the settings follow; see `Car.nominal`.
        laps: laps of an episode; `None`: no end.
        normalise: whether actions lie in [-1, 1].
        ahead: times ahead, see above [s].
        failure_cost: see above; by default a tenth of the track's length [m].
        random_start: whether an episode begins at a random place instead of at the line.
        body: whether the whole body has to stay inside, or only the centre of gravity.
        render_mode: ``rgb_array`` or `None`.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}

    def __init__(
        self,
        car: Any = "barc",
        track: Any = "l",
        config: Any = None,
        *,
        changes: Any = None,
        nominal_mu: float | None = None,
        laps: int | None = 20,
        normalise: bool = True,
        ahead: tuple[float, ...] = AHEAD,
        failure_cost: float | None = None,
        random_start: bool = False,
        body: bool | None = None,
        render_mode: str | None = None,
    ) -> None:
        self.car = car if isinstance(car, lmpc.Car) else lmpc.Car(car)
        self.track = track if isinstance(track, lmpc.Track) else lmpc.Track(track)
        self.config = config.copy() if isinstance(config, lmpc.Config) else lmpc.Config(keys=config)
        self.nominal = self.car.nominal(nominal_mu)
        values = self.config.values(self.nominal, self.track)
        self.period: float = values["horizon.period_s"]
        self.start_speed: float = values["warm_up.speed_mps"]
        self.laps = laps
        self.normalise = normalise
        self.random_start = random_start
        self.failure_cost = 0.1 * self.track.length if failure_cost is None else failure_cost
        self.render_mode = render_mode
        self.plant = lmpc.Plant(self.car, self.track, self._start(0.0), changes)
        # The car that drives has to stay inside; a lap may take as long as its controller's settings say.
        settings = self.config.copy().set("warm_up.speed_mps", self.start_speed)
        self.rule = lmpc.FailureRule(self.plant.car, self.track, settings, body)
        self._ahead = np.asarray(ahead, dtype=float)
        self._limits = np.array(self.plant.car.limits)
        self._steps = 0
        self._lap_start = 0.0
        self._laps_before = 0

        a_min, a_max, delta = self._limits
        if normalise:
            self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float32)
        else:
            ends = np.array([[a_min, -delta], [a_max, delta]])
            self.action_space = gymnasium.spaces.Box(ends[0], ends[1], dtype=np.float64)
        n = len(self._ahead)
        kappa = self.track.max_abs_kappa
        own = [_FASTEST, _FASTEST, _TURNING, np.pi, _WIDEST]
        low = [-v for v in own] + [a_min, -delta] + n * [-kappa] + 2 * n * [0.0]
        high = [*own, a_max, delta] + n * [kappa] + 2 * n * [_WIDEST]
        # Rounded outwards, so that the limits themselves lie inside.
        self.observation_space = gymnasium.spaces.Box(
            np.nextafter(np.array(low, np.float32), np.float32(-np.inf)),
            np.nextafter(np.array(high, np.float32), np.float32(np.inf)),
        )

    def _start(self, s: float) -> NDArray[np.float64]:
        """Centred at `s`, along the track, at the speed of the warm-up laps."""
        return np.array([self.start_speed, 0.0, 0.0, 0.0, s, 0.0])

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Puts the car back to its start.

        Args:
            seed: of the sensor noise, the disturbances and the random start; without one they go
                on from the episode before.
            options: ``{"x": state (6,)}`` to start from a state of your own.
        """
        super().reset(seed=seed)
        x = (options or {}).get("x")
        if x is None:
            place = self.np_random.uniform(0.0, self.track.length) if self.random_start else 0.0
            x = self._start(place)
        noise = int(self.np_random.integers(2**62)) if seed is None else seed
        self.plant.reset(x, noise)
        self._steps = 0
        self._lap_start = 0.0
        self._laps_before = self.plant.lap
        return self._observe(None, None)

    def step(
        self, action: NDArray[Any]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Drives for one period with an action, see the class."""
        before = self.plant.progress
        lap = self.plant.lap
        self.plant.apply(self.to_input(action), self.period)
        self._steps += 1
        time = self._steps * self.period
        progress = self.plant.progress - before
        lap_time = None
        if self.plant.lap > lap:
            # The line was crossed this long before the end of the step.
            beyond = self.plant.progress - self.plant.lap * self.track.length
            crossed = time - self.period * beyond / max(progress, 1e-9)
            lap_time = crossed - self._lap_start
            self._lap_start = crossed
        failure = self.rule.broken(self.plant.truth, time - self._lap_start)
        reward = progress - (self.failure_cost if failure else 0.0)
        done = self.plant.lap - self._laps_before
        truncated = self.laps is not None and done >= self.laps
        observation, info = self._observe(lap_time, failure)
        return observation, float(reward), failure is not None, truncated, info

    def to_input(self, action: NDArray[Any]) -> NDArray[np.float64]:
        """The input ``[a, delta]`` (2,) of an action (2,)."""
        u = np.asarray(action, dtype=float)
        if not self.normalise:
            return u
        a_min, a_max, delta = self._limits
        a, steering = np.clip(u, -1.0, 1.0)
        return np.array([a * a_max if a > 0 else -a * a_min, steering * delta])

    def to_action(self, u: NDArray[Any]) -> NDArray[Any]:
        """The action (2,) of an input ``[a, delta]`` (2,)."""
        if not self.normalise:
            return np.asarray(u, dtype=float)
        a_min, a_max, delta = self._limits
        a = u[0] / a_max if u[0] > 0 else -u[0] / a_min
        return np.clip(np.array([a, u[1] / delta]), -1.0, 1.0).astype(np.float32)

    def _observe(
        self, lap_time: float | None, failure: str | None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        x = self.plant.measure()
        places = x[4] + max(x[0], self.start_speed) * self._ahead
        track = self.track
        parts = [
            x[[0, 1, 2, 3, 5]],
            self.plant.applied,
            track.kappa(places),
            track.width_left(places),
            track.width_right(places),
        ]
        box = self.observation_space
        assert isinstance(box, gymnasium.spaces.Box)
        observation = np.clip(np.concatenate(parts).astype(np.float32), box.low, box.high)
        info = {
            "x": x,
            "truth": self.plant.truth,
            "time": self._steps * self.period,
            "lap": self.plant.lap - self._laps_before,
            "progress": self.plant.progress,
            "lap_time": lap_time,
            "failure": failure,
        }
        return observation, info

    def render(self) -> NDArray[np.uint8] | None:
        """The track with the car from above, (height, width, 3), if ``render_mode`` says so."""
        if self.render_mode is None:
            return None
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        s = np.linspace(0.0, self.track.length, 500)
        figure = Figure(figsize=(6, 6), dpi=100)
        canvas = FigureCanvasAgg(figure)
        axes = figure.add_subplot(aspect="equal")
        for edge in (self.track.left_edge(s), self.track.right_edge(s)):
            axes.plot(*edge.T, color="0.3", linewidth=1)
        x, y, psi = self.plant.pose[:3]
        length, width = self.car.size
        corners = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * [length / 2, width / 2]
        turn = np.array([[np.cos(psi), np.sin(psi)], [-np.sin(psi), np.cos(psi)]])
        axes.fill(*(corners @ turn + [x, y]).T, color="tab:blue")
        axes.plot(x, y, "o", color="tab:blue", markersize=4)
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[..., :3].copy()


class LmpcAgent:
    """The learning controller as an agent: it drives a `RaceEnv` and learns from its laps.

    >>> env = RaceEnv()
    >>> agent = LmpcAgent(env)
    >>> observation, info = env.reset(seed=0)
    >>> agent.reset(seed=0)
    >>> done = False
    >>> while not done:
    ...     observation, reward, failed, ended, info = env.step(agent.act(observation, info))
    ...     done = failed or ended

    It acts on the measured state ``info["x"]``; an observation has not all of it.

    Args:
        env: the environment, with or without wrappers that leave actions and info as they are.
    """

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        inner = env.unwrapped
        if not isinstance(inner, RaceEnv):
            raise lmpc.Error(f"LmpcAgent: found {inner!r}, expected a RaceEnv")
        self.env = inner
        #: The controller; its laps, plan and model can be looked at.
        self.controller = self._new(0)
        #: What the last step did; `None` before the first.
        self.status: lmpc.Status | None = None

    def _new(self, seed: int) -> lmpc.Controller:
        config = self.env.config.copy().set("warm_up.seed", seed)
        return lmpc.Controller(self.env.nominal, self.env.track, config)

    def reset(self, seed: int = 0, forget: bool = True) -> None:
        """Prepares for an episode.

        Args:
            seed: of the excitation in the warm-up laps.
            forget: whether to begin with warm-up laps, or to keep what was learned.
        """
        learned = b"" if forget or not self.controller.laps else self.controller.save()
        self.controller = self._new(seed)
        if learned:
            self.controller.load(learned)
        self.status = None

    def act(self, observation: Any, info: dict[str, Any]) -> NDArray[Any]:
        """The action (2,) for what the environment returned."""
        u, self.status = self.controller.step(info["x"], info["time"])
        return self.env.to_action(u)


gymnasium.register(id="RacingLMPC-v0", entry_point="racing_lmpc.gym:RaceEnv")
