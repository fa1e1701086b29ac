"""Controller and plant, step by step."""

import pickle
import threading

import numpy as np
import pytest

import racing_lmpc as lmpc


def drive(controller, plant, laps):
    """Drives until the controller has closed this many laps; inputs and actions of the steps."""
    inputs, actions = [], []
    while len(controller.laps) < laps:
        u, status = controller.step(plant.measure())
        plant.apply(u, controller.period)
        inputs.append(u)
        actions.append(status.action)
    return np.array(inputs), actions


def pair(track="l", **keys):
    car = lmpc.Car("barc")
    controller = lmpc.Controller(car.nominal(), track, keys or None)
    return controller, lmpc.Plant(car, track, x=[controller.warm_up_speed, 0, 0, 0, 0, 0])


def test_a_loop_in_python_is_the_race_bit_for_bit():
    controller, plant = pair()
    inputs, actions = drive(controller, plant, 7)
    race = lmpc.race(laps=3)
    assert np.array_equal(inputs[: len(race.u)], race.u)
    assert actions[: len(race.u)] == race.trajectory["action"].tolist()
    times = [lap["lap_time"] for lap in controller.laps]
    assert times == race.laps["lap_time_s"].tolist()
    lap = controller.laps[-1]
    assert lap["x"].shape == (len(lap["time"]), 6) and lap["u"].shape == (len(lap["time"]), 2)


def test_the_inside_of_a_step_is_consistent():
    controller, plant = pair()
    assert controller.plan.x.shape == (0, 6)
    drive(controller, plant, 5)
    x = plant.measure()
    u, status = controller.step(x)
    assert status.action == "learned" and np.array_equal(status.state, x)
    plan, steps = controller.plan, controller.step
    assert plan.x.shape == (len(plan.u) + 1, 6) and np.allclose(plan.u[0], u, atol=1e-9)
    safe = controller.safe_set
    assert safe.points.shape == (len(safe.cost_to_go), 6)
    assert len(safe.weights) == len(safe.points) and abs(safe.weights.sum() - 1) < 1e-6
    assert abs(safe.weights @ safe.cost_to_go - status.cost_to_go) < 1e-6
    model = controller.learned_model(x, u)
    for whole, nominal, error in zip(model.sum, model.nominal, model.error):
        assert np.allclose(whole, nominal + error, rtol=0, atol=1e-12)
    a, b, c = model.sum
    # The learned model predicts the plant.
    plant.apply(u, controller.period)
    after = plant.truth
    assert np.abs(a @ x + b @ u + c - after)[:3].max() < 0.1


def test_states_are_resumed_bit_for_bit():
    controller, plant = pair()
    drive(controller, plant, 5)
    states = controller.state, plant.state
    first, _ = drive(controller, plant, 6)
    controller.resume(states[0])
    plant.restore(states[1])
    second, _ = drive(controller, plant, 6)
    assert np.array_equal(first, second)


def test_learned_data_as_bytes_and_as_a_file(tmp_path):
    controller, plant = pair()
    drive(controller, plant, 6)
    controller.finish_learning()
    data = controller.save()
    controller.save_file(tmp_path / "today.lmpc")
    assert (tmp_path / "today.lmpc").read_bytes() == data
    second, plant = pair()
    second.load(data)
    third, _ = pair()
    third.load_file(tmp_path / "today.lmpc")
    x = plant.measure()
    (u, status), (v, _) = second.step(x), third.step(x)
    assert status.action == "learned" and np.array_equal(u, v)

    first = lmpc.race(laps=2)
    again = lmpc.race(laps=2, learned=first.learned)
    first.save_file(tmp_path / "race.lmpc")
    filed = lmpc.race(laps=2, learned=tmp_path / "race.lmpc")
    assert again.laps["kind"].tolist() == ["learning"] * 2
    assert np.array_equal(again.x, filed.x)

    with pytest.raises(lmpc.DataError, match="LMPCDATA"):
        second.load(b"nothing of ours")
    with pytest.raises(lmpc.DataError, match="another track"):
        lmpc.race(track="road_course", learned=data)
    with pytest.raises(lmpc.DataError, match="cannot read"):
        second.load_file(tmp_path / "none.lmpc")


def test_global_poses_are_projected():
    first, plant = pair()
    second, _ = pair()
    for _ in range(60):
        u, _ = first.step(plant.truth)
        v, status = second.step_global(plant.pose)
        assert np.abs(u - v).max() < 1e-6
        plant.apply(u, first.period)


def test_the_plant_has_its_changes_and_its_noise():
    bare, noisy = (lmpc.Plant("barc", "l", [1, 0, 0, 0, 0, 0], plant) for plant in
                   (None, {"noise": 0.01, "mu": 0.5}))
    assert np.array_equal(bare.measure(), bare.truth)
    assert not np.array_equal(noisy.measure(), noisy.truth)
    assert noisy.car.mu == (0.5, 0.5) and bare.car == lmpc.Car("barc")
    bare.apply([1.0, 0.0], 0.1)
    assert bare.time == 0.1 and bare.progress > 0.1 and bare.lap == 0
    assert np.array_equal(bare.applied, [1.0, 0.0])
    noisy.reset(seed=3)
    first = noisy.measure()
    noisy.reset(seed=3)
    assert np.array_equal(first, noisy.measure())
    noisy.reset(seed=4)
    assert not np.array_equal(first, noisy.measure())


def test_races_run_side_by_side():
    races = {}
    threads = [threading.Thread(target=lambda s=seed: races.update({s: lmpc.race(laps=1, seed=s)}))
               for seed in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for seed, race in races.items():
        assert np.array_equal(race.x, lmpc.race(laps=1, seed=seed).x)
    assert len(races) == 3


def test_a_race_leaves_the_interpreter_to_others():
    thread = threading.Thread(target=lmpc.race)
    thread.start()
    count = 0
    while thread.is_alive():
        count += 1
    thread.join()
    # With its lock held, this thread would not run before the race ends.
    assert count > 100


def test_cars_tracks_and_configurations_are_pickled():
    car = lmpc.Car("iac").with_keys({"mass_kg": 700, "tyre_front.mu": 1.4})
    track = lmpc.Track.random(3, lmpc.Car("barc"))
    config = lmpc.Config("paper", keys={"horizon.steps": 9}).set("delay.steps", 1)
    again, road, settings = pickle.loads(pickle.dumps((car, track, config)))
    assert again == car and again.mass == 700 and again.mu[0] == 1.4
    assert road == track and road.name == track.name
    assert settings.values("barc", "l") == config.values("barc", "l")
    assert lmpc.Car("barc") != car and lmpc.Track("l") != track
    assert pickle.loads(pickle.dumps(lmpc.Car("barc"))).nominal().mu == (1.2, 1.2)
