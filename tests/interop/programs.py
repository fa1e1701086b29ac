"""Programs of ours that a test of `lmpc view` starts: those of view.py and foxglove.py, which are called with

    LMPC FOLDER
"""

import pathlib
import signal
import subprocess
import sys

LMPC, OUT = sys.argv[1], pathlib.Path(sys.argv[2])
FAST = ["--config", "config/barc_100hz.toml", "--set", "warm_up.laps=1"]
running = []


def start(name, *args):
    """A program of ours; what it prints goes to a file of its own."""
    log = open(OUT / f"{name}.txt", "a")
    program = subprocess.Popen([LMPC, *args], stdout=log, stderr=log)
    running.append(program)
    return program


def end(program):
    program.send_signal(signal.SIGINT)
    assert program.wait(10) in (0, 1, 3), program.args
    running.remove(program)
