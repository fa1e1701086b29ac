"""A vehicle in Python on the controller's network: own plant, types generated from our .lcm files.

    lmpc serve                                  # in one terminal
    python examples/lcm/python_vehicle.py       # in another; needs `pip install lcm`

Time stands still until each state is answered, so five laps take seconds. Ends with 0 when all
laps stayed on the track.
"""

import argparse
import glob
import os
import sys
import time
import zlib

import lcm

from plant import Plant, types

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
PERIOD = 0.1


def sealed(message):
    """Encoded, with the CRC-32 of everything before it in the last four bytes."""
    body = message.encode()[:-4]
    return body + zlib.crc32(body).to_bytes(4, "big")


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--url", default=os.environ.get("LCM_DEFAULT_URL", "udpm://239.255.76.67:7667?ttl=0"))
    options.add_argument("--laps", type=int, default=5, help="laps to drive [-]")
    options.add_argument("--patience", type=float, default=60.0, help="longest wait for an answer [s]")
    args = options.parse_args()
    (lmpc,) = types(*sorted(glob.glob(os.path.join(ROOT, "lcm_types", "lcm", "*.lcm"))))
    network = lcm.LCM(args.url)
    plant, laps, answer = Plant(), [], {}
    boot_id = int.from_bytes(os.urandom(7), "big") + 1
    seq = steps = refused = 0

    def on_command(_, data):
        nonlocal refused
        if zlib.crc32(data[:-4]) != int.from_bytes(data[-4:], "big"):
            refused += 1
            return
        command = lmpc.actuation_command_t.decode(data)
        if command.enable and command.state_boot_id == boot_id:
            answer[command.state_mono_ns] = command

    network.subscribe("LMPC/CMD", on_command)
    network.subscribe("LMPC/LAP", lambda _, data: laps.append(lmpc.lap_result_t.decode(data)))
    while len(laps) < args.laps:
        state = lmpc.vehicle_state_t()
        state.meas_mono_ns = round(steps * PERIOD * 1e9)
        state.valid = state.POSE | state.VEL | state.ACC
        state.quality = 2
        state.x, state.y, state.yaw = plant.x, plant.y, plant.psi
        state.vx, state.vy, state.yaw_rate = plant.v_x, plant.v_y, plant.omega_z
        state.ax, state.ay = plant.a_x, plant.a_y
        deadline = time.monotonic() + args.patience
        answer.clear()
        while state.meas_mono_ns not in answer:
            if time.monotonic() > deadline:
                sys.exit(f"no answer to the state of {steps * PERIOD:.1f} s: is `lmpc serve` running?")
            # Said again, it is answered again: a datagram may be lost.
            state.h.utime, state.h.mono_ns = time.time_ns() // 1000, time.monotonic_ns()
            state.h.seq, state.h.boot_id, state.h.sender = seq, boot_id, "python_vehicle@here"
            seq += 1
            network.publish("CAR/STATE", sealed(state))
            again = time.monotonic() + 0.2
            while state.meas_mono_ns not in answer and (left := again - time.monotonic()) > 0:
                network.handle_timeout(max(1, int(left * 1e3)))
        command = answer[state.meas_mono_ns]
        plant.drive(command.accel, command.steer, PERIOD)
        steps += 1
        # The word of a closed lap follows its command.
        while network.handle_timeout(1):
            pass
    for lap in laps:
        print(f"lap {lap.lap}  {lap.lap_time:.3f} s  {'on the track' if lap.valid else 'OFF THE TRACK'}")
    print(f"{steps} commands, {refused} refused")
    return 0 if all(lap.valid for lap in laps) and refused == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
