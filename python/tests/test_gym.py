"""The environment by Gymnasium's own checker, and the controller in it."""

import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import racing_lmpc as lmpc
from racing_lmpc.gym import LmpcAgent, RaceEnv


@pytest.mark.parametrize("car, track", [("barc", "l"), ("kart", "road_course")])
@pytest.mark.parametrize("normalise", [True, False])
def test_the_checker_passes(car, track, normalise):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Actions in m/s^2 and rad are asked for.
        warnings.filterwarnings("ignore", message=".*symmetric and normalized space.*")
        env = gymnasium.make(
            "RacingLMPC-v0", car=car, track=track, normalise=normalise, render_mode="rgb_array",
            random_start=True, changes={"noise": 0.001},
        )
        check_env(env.unwrapped)


def episode(env, agent, seed=0, forget=True):
    observation, info = env.reset(seed=seed)
    agent.reset(seed=seed, forget=forget)
    states, inputs, infos, total, done = [], [], [info], 0.0, False
    while not done:
        states.append(info["truth"])
        action = agent.act(observation, info)
        inputs.append(env.unwrapped.to_input(action))
        observation, reward, failed, ended, info = env.step(action)
        total += reward
        infos.append(info)
        done = failed or ended
    return np.array(states), np.array(inputs), infos, total


@pytest.mark.parametrize("changes", [None, {"noise": 0.001}])
def test_the_agent_drives_the_race_bit_for_bit(changes):
    env = RaceEnv(normalise=False, laps=7, changes=changes)
    states, inputs, infos, total = episode(env, LmpcAgent(env), seed=2)
    race = lmpc.race(laps=2, seed=2, plant=changes)
    assert race.failure is None
    count = len(race.x)
    assert np.array_equal(states[:count], race.x) and np.array_equal(inputs[:count], race.u)
    times = [info["lap_time"] for info in infos if info["lap_time"] is not None]
    assert len(times) == 7 and infos[-1]["lap"] == 7
    if changes is None:
        assert np.allclose(times[: len(race.laps["lap"])], race.laps["lap_time_s"], atol=1e-2)
    assert total == pytest.approx(infos[-1]["progress"])


def test_a_registered_and_wrapped_environment_is_driven_with_normalised_actions():
    env = gymnasium.make("RacingLMPC-v0", laps=6)
    agent = LmpcAgent(env)
    _, inputs, infos, _ = episode(env, agent)
    assert infos[-1]["failure"] is None and agent.status.action == "learned"
    a_min, a_max, delta = lmpc.Car("barc").limits
    assert inputs[:, 0].min() >= a_min and inputs[:, 0].max() <= a_max
    assert np.abs(inputs[:, 1]).max() <= delta
    for u in ([a_min, delta], [a_max, -delta], [0.0, 0.0], [0.3, 0.1]):
        inner = env.unwrapped
        assert np.allclose(inner.to_input(inner.to_action(np.array(u))), u, atol=1e-6)
    # What was learned is kept for the next episode: it begins with learned laps.
    laps = len(agent.controller.laps)
    observation, info = env.reset(seed=1)
    agent.reset(seed=1, forget=False)
    assert len(agent.controller.laps) == laps
    agent.act(observation, info)
    assert agent.status.action == "learned"


def test_the_observation_is_what_it_says():
    env = RaceEnv("kart", "road_course", ahead=(0.0, 1.0))
    observation, info = env.reset(seed=0, options={"x": [9.0, 0.1, 0.2, 0.05, 30.0, -0.5]})
    x, track = info["x"], lmpc.Track("road_course")
    assert np.allclose(observation[:5], x[[0, 1, 2, 3, 5]]) and observation.shape == (13,)
    s = [30.0, 30.0 + max(9.0, env.start_speed)]
    assert np.allclose(observation[7:9], track.kappa(s), atol=1e-6)
    assert np.allclose(observation[9:11], track.width_left(s))
    assert np.allclose(observation[11:], track.width_right(s))


def test_a_car_that_fails_ends_the_episode_and_pays():
    env = RaceEnv(failure_cost=5.0)
    env.reset(seed=0)
    done, rewards = False, []
    while not done:
        _, reward, done, truncated, info = env.step(np.array([1.0, 1.0], np.float32))
        rewards.append(reward)
        assert not truncated
    assert info["failure"] in ("off_track", "spin") and rewards[-1] < -4.0
    assert all(reward > 0 for reward in rewards[:-1])
