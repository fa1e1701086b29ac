"""A simulated car that knows nothing of our messages: it sends bot_core.pose_t of its rear axle on
POSE and obeys example.driving_command_t on DRIVING_COMMAND.

    lmpc serve
    lmpc vehicle car --map examples/lcm/car.toml
    python examples/lcm/foreign_car.py          # needs `pip install lcm`

Time stands still until a command bears the time stamp of the last pose. After the distance it
waits with `--then-stop` until the car is told to stop. With `--rate 50` it drives in real time
instead, as `lmpc bridge --vehicle car` needs it, and ends when it stands after the distance.
"""

import argparse
import os
import sys
import time
from math import cos, hypot, radians, sin

import lcm

from plant import Plant, types

HERE = os.path.dirname(os.path.abspath(__file__))
PERIOD = 0.1


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--url", default=os.environ.get("LCM_DEFAULT_URL", "udpm://239.255.76.67:7667?ttl=0"))
    options.add_argument("--distance", type=float, default=90.0, help="distance to drive [m]")
    options.add_argument("--patience", type=float, default=60.0, help="longest wait for an answer [s]")
    options.add_argument("--then-stop", action="store_true", help="wait for the stop, then end")
    options.add_argument("--rate", type=float, default=0.0, help="poses a second, in real time; 0: lock-step [Hz]")
    args = options.parse_args()
    bot_core, example = types(os.path.join(HERE, "bot_core.lcm"), os.path.join(HERE, "driving.lcm"))
    network, plant, commands = lcm.LCM(args.url), Plant(0.0 if args.rate > 0.0 else 1.2), []
    network.subscribe("DRIVING_COMMAND", lambda _, data: commands.append(example.driving_command_t.decode(data)))
    # A clock of its own, unrelated to anyone's.
    utime, steps, driven = 1_234_567_890_123, 0, 0.0

    def say():
        pose = bot_core.pose_t()
        c, s, omega = cos(plant.psi), sin(plant.psi), plant.omega_z
        v_y = plant.v_y - Plant.L_R * omega
        pose.utime = utime
        pose.pos = [plant.x - Plant.L_R * c, plant.y - Plant.L_R * s, 0.1]
        pose.vel = [plant.v_x * c - v_y * s, plant.v_x * s + v_y * c, 0.0]
        pose.orientation = [cos(plant.psi / 2), 0.0, 0.0, sin(plant.psi / 2)]
        pose.rotation_rate = [0.0, 0.0, omega]
        pose.accel = [plant.a_x, plant.a_y, 9.81]
        network.publish("POSE", pose.encode())

    def answered():
        return next((c for c in commands if c.timestamp == utime), None)

    def obey(command, duration):
        assert 0.0 <= command.throttle <= 1.0 and 0.0 <= command.brake <= 1.0
        plant.drive(2.0 * (command.throttle - command.brake), radians(-command.steering_angle), duration)
        return hypot(plant.v_x, plant.v_y) * duration

    if args.rate > 0.0:
        period, command = 1.0 / args.rate, example.driving_command_t()
        command.brake = 1.0
        due = time.monotonic()
        deadline = due + args.patience
        while driven < args.distance or plant.v_x > 0.01:
            say()
            due += period
            while (left := due - time.monotonic()) > 0:
                network.handle_timeout(max(1, int(left * 1e3)))
            command = commands[-1] if commands else command
            commands.clear()
            driven += obey(command, period)
            utime += round(period * 1e6)
            if time.monotonic() > deadline:
                sys.exit(f"{driven:.1f} m at {plant.v_x:.2f} m/s after {args.patience:.0f} s")
        print(f"stands after {driven:.1f} m")
        return

    while driven < args.distance:
        deadline = time.monotonic() + args.patience
        while (command := answered()) is None:
            if time.monotonic() > deadline:
                sys.exit(f"no command after {driven:.1f} m: are `lmpc serve` and `lmpc vehicle car` running?")
            say()
            again = time.monotonic() + 0.2
            while answered() is None and (left := again - time.monotonic()) > 0:
                network.handle_timeout(max(1, int(left * 1e3)))
        driven += obey(command, PERIOD)
        utime += round(PERIOD * 1e6)
        steps += 1
        commands.clear()
    print(f"{steps} commands, {driven:.1f} m, {plant.v_x:.2f} m/s")
    if args.then_stop:
        print("driven", flush=True)
        begun = time.monotonic()
        while not any(c.throttle == 0.0 and c.brake == 1.0 for c in commands):
            if time.monotonic() > begun + args.patience:
                sys.exit("the car was not told to stop")
            commands.clear()
            network.handle_timeout(50)
        print(f"told to stop {time.monotonic() - begun:.3f} s after the last pose")


if __name__ == "__main__":
    main()
