"""A small car that is not ours: dynamic bicycle in the world frame with a saturating tyre, steps of
1 ms, and the classes lcm-gen makes of `.lcm` files."""

import importlib
import os
import subprocess
import sys
import tempfile
from math import atan2, cos, sin, tanh

import lcm

STEP = 1e-3
GRAVITY = 9.81


class Plant:
    """State x, y [m], psi [rad], v_x, v_y [m/s] (body), omega_z [rad/s], at the centre of mass."""

    MASS, INERTIA, L_F, L_R, MU, STIFFNESS = 2.2187, 0.02723, 0.13, 0.13, 0.85, 9.5

    def __init__(self, v_x=1.2):
        self.x = self.y = self.psi = self.v_y = self.omega_z = self.a_x = self.a_y = 0.0
        self.v_x = v_x

    def drive(self, a, delta, duration):
        """Applies an acceleration [m/s^2] and a steering angle [rad] for a while [s]."""
        load = self.MU * self.MASS * GRAVITY / (self.L_F + self.L_R)
        for _ in range(round(duration / STEP)):
            v = max(self.v_x, 0.3)
            slip_f = delta - atan2(self.v_y + self.L_F * self.omega_z, v)
            slip_r = -atan2(self.v_y - self.L_R * self.omega_z, v)
            force_f = load * self.L_R * tanh(self.STIFFNESS * slip_f)
            force_r = load * self.L_F * tanh(self.STIFFNESS * slip_r)
            # Brakes do not drive a car backwards.
            drive = a if a > 0.0 or self.v_x > 0.0 else 0.0
            self.a_x = drive - force_f * sin(delta) / self.MASS
            self.a_y = (force_f * cos(delta) + force_r) / self.MASS
            turn = (self.L_F * force_f * cos(delta) - self.L_R * force_r) / self.INERTIA
            self.x += STEP * (self.v_x * cos(self.psi) - self.v_y * sin(self.psi))
            self.y += STEP * (self.v_x * sin(self.psi) + self.v_y * cos(self.psi))
            self.psi += STEP * self.omega_z
            v_x = self.v_x + STEP * (self.a_x + self.omega_z * self.v_y)
            v_y = self.v_y + STEP * (self.a_y - self.omega_z * self.v_x)
            self.v_x, self.v_y = max(v_x, 0.0), v_y
            self.omega_z += STEP * turn


def types(*files):
    """Imports what lcm-gen makes of these files: a module for each package, by name."""
    site = os.path.dirname(os.path.dirname(lcm.__file__))
    folder = tempfile.mkdtemp(prefix="lcm-types-")
    generator = os.path.join(site, "bin", "lcm-gen")
    subprocess.run([generator, "--python", "--ppath", folder, *files], check=True)
    sys.path.insert(0, folder)
    packages = sorted(name for name in os.listdir(folder) if os.path.isdir(f"{folder}/{name}"))
    return [importlib.import_module(name) for name in packages]
