"""Cars, tracks, configurations and what is refused."""

import numpy as np
import pytest

import racing_lmpc as lmpc


def test_a_track_of_arrays():
    angle = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    x, y = 20 * np.cos(angle), 20 * np.sin(angle)
    track = lmpc.Track.from_points(x, y, 2.0, np.full(200, 3.0), "circle")
    assert track.name == "circle" and abs(track.length - 40 * np.pi) < 1e-3
    s = np.linspace(0, 3 * track.length, 12).reshape(3, 4)
    assert np.allclose(track.kappa(s), 1 / 20, atol=1e-4) and track.kappa(s).shape == (3, 4)
    assert np.allclose(np.hypot(*np.moveaxis(track.left_edge(s), -1, 0)), 18, atol=1e-3)
    assert np.allclose(np.hypot(*np.moveaxis(track.right_edge(s), -1, 0)), 23, atol=1e-3)
    assert np.allclose(track.position(s), track.position(s, 0.0)) and track.kappa(1.0).shape == ()
    assert lmpc.Track.from_text(track.to_toml()) == track
    state = np.array([5.0, 0.1, 0.2, 0.05, 30.0, -0.5])
    assert np.allclose(track.to_frenet(track.to_global(state)), state, atol=1e-9)
    noise = np.random.default_rng(0).normal(0, 0.05, 200)
    smooth = lmpc.Track.from_points(x + noise, y, 2.0, 3.0, smooth=None)
    assert smooth.changes and smooth.max_abs_kappa < 0.2
    race = lmpc.race(track=track, laps=1)
    assert race.failure is None and race.track == track


def test_a_track_of_segments():
    turn = np.pi * 5
    lengths, kappas = [20, turn, 20, turn], [0, 0.2, 0, 0.2]
    track = lmpc.Track.from_segments(lengths, kappas, 1.5, 1.5, "oval")
    assert abs(track.length - (40 + 2 * turn)) < 1e-9 and track.max_abs_kappa == 0.2
    assert lmpc.Track.from_text(track.to_toml()) == track


def test_files_are_read_and_written(tmp_path):
    text = lmpc.Car("kart").to_toml()
    (tmp_path / "kart.toml").write_text(text)
    assert lmpc.Car(tmp_path / "kart.toml") == lmpc.Car("kart")
    (tmp_path / "track.toml").write_text(lmpc.Track("l").to_toml())
    assert lmpc.Track(str(tmp_path / "track.toml")) == lmpc.Track("l")
    (tmp_path / "config.toml").write_text("[horizon]\nsteps = 8\n")
    values = lmpc.Config(file=tmp_path / "config.toml").values("barc", "l")
    assert values["horizon.steps"] == 8 and len(values) > 40


def test_settings_and_where_they_come_from():
    config = lmpc.Config(keys={"horizon.steps": np.int64(9), "limits.lane_margin_m": 0.2})
    config.set("regression.mode", "full").set("delay.estimate", False)
    config.set("regression.metric", [1, 2.5, 1, 1, 1])
    values, origins = config.values("barc", "l"), config.origins("barc", "l")
    assert values["horizon.steps"] == 9 and values["limits.lane_margin_m"] == 0.2
    assert values["regression.mode"] == "full" and values["delay.estimate"] is False
    assert values["regression.metric"] == [1, 2.5, 1, 1, 1]
    assert origins["horizon.steps"] == "command line" and "car" in origins["warm_up.speed_mps"]
    copy = config.copy().set("horizon.steps", 10)
    assert copy.values("barc", "l")["horizon.steps"] == 10
    assert config.values("barc", "l")["horizon.steps"] == 9
    assert lmpc.Config("paper").values("barc", "l")["preset" if False else "horizon.steps"] == 13


@pytest.mark.parametrize(
    "kind, message, call",
    [
        (lmpc.CarError, "no car of that name", lambda: lmpc.Car("bark")),
        (lmpc.CarError, "mass_kg", lambda: lmpc.Car("barc").with_keys({"mass_kg": -1})),
        (lmpc.CarError, "mass_kgs", lambda: lmpc.Car("barc").with_keys({"mass_kgs": 1})),
        (lmpc.TrackError, "no track of that name", lambda: lmpc.Track("nowhere.csv")),
        (lmpc.TrackError, "3", lambda: lmpc.Track.from_points([0, 1, 2], [0, 0, 1], 1, 1)),
        (lmpc.Error, "y: found 2 numbers", lambda: lmpc.Track.from_points([0, 1, 2], [0, 1], 1, 1)),
        (lmpc.ConfigError, "stepz", lambda: lmpc.Config(keys={"horizon.stepz": 3})),
        (lmpc.ConfigError, "horizon.steps", lambda: lmpc.Config().set("horizon.steps", 1)),
        (lmpc.ConfigError, "sport", lambda: lmpc.Config("sport")),
        (lmpc.ConfigError, "cannot read", lambda: lmpc.Config(file="none.toml")),
        (lmpc.ConfigError, "no lane",
         lambda: lmpc.Controller("barc", "l", {"limits.lane_margin_m": 0.9})),
        (lmpc.CarError, "mu", lambda: lmpc.race(plant={"mu": -1})),
        (lmpc.CarError, "`grip`", lambda: lmpc.race(plant={"grip": 1})),
        (lmpc.CarError, "nominal-mu", lambda: lmpc.race(nominal_mu=-1)),
        (lmpc.Error, "expected 6 numbers", lambda: lmpc.Plant("barc", "l", [1, 2])),
        (lmpc.Error, "expected 2 numbers",
         lambda: lmpc.Plant("barc", "l").apply(np.zeros(3), 0.1)),
        (lmpc.Error, "'fast'", lambda: lmpc.Plant("barc", "l").apply("fast", 0.1)),
        (lmpc.OptimumError, "margin", lambda: lmpc.optimum("barc", "l", margin=-1)),
    ],
)
def test_what_is_refused_is_named(kind, message, call):
    with pytest.raises(kind) as caught:
        call()
    assert message in str(caught.value) and not str(caught.value).startswith("--")
    assert isinstance(caught.value, ValueError)


def test_what_is_not_finite_is_no_exception_in_a_step():
    controller = lmpc.Controller("barc", "l")
    u, status = controller.step([np.nan] * 6)
    assert status.reason == "non_finite" and np.isfinite(u).all()


def test_the_optimal_lap_is_faster_than_a_race():
    best = lmpc.optimum("barc", "l", starts=1)
    assert best.x.shape == (len(best.time), 6) and best.u.shape == (len(best.time), 2)
    assert best.time[-1] == pytest.approx(best.lap_time) and best.quality["scaled_defect"] < 1e-3
    assert best.lap_time < lmpc.race(laps=5).best_lap


def test_rules_judge_as_a_race_does():
    rule = lmpc.FailureRule("barc", "l")
    race = lmpc.race(laps=1)
    assert all(rule.broken(x, 1.0) is None for x in race.x)
    beyond = np.array([rule.beyond(x) for x in race.x])
    assert np.array_equal(beyond, race.trajectory["overhang_m"])
    assert rule.broken([1, 0, 0, 2, 1, 0], 0) == "wrong_way"
    assert lmpc.FailureRule("barc", "l", body=False).beyond([1, 0, 0, 0, 0, 0]) < beyond[0]
