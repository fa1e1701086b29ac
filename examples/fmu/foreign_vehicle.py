"""A car that is not ours, for PythonFMU to export: a dynamic bicycle in the global frame with a
brush-like tyre, explicit Euler at 1 ms. It shares no equation file, integrator or frame with the
vehicle FMU.

    pythonfmu build -f examples/fmu/foreign_vehicle.py -d out/fmu/foreign
"""

from math import atan2, cos, pi, sin, tanh

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

STEP = 1e-3
GRAVITY = 9.81


class ForeignVehicle(Fmi2Slave):
    author = "example"
    description = "Dynamic bicycle in the global frame"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.a = 0.0
        self.delta = 0.0
        self.x = 0.0
        self.y = 0.0
        self.psi = 0.0
        self.v_x = 1.2
        self.v_y = 0.0
        self.omega_z = 0.0
        self.mass = 2.2187
        self.inertia = 0.02723
        self.l_f = 0.13
        self.l_r = 0.13
        self.mu = 0.85
        self.stiffness = 9.5
        for name in ("a", "delta"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name in ("x", "y", "psi", "v_x", "v_y", "omega_z"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))
        for name in ("mass", "inertia", "l_f", "l_r", "mu", "stiffness"):
            self.register_variable(Real(name, causality=Fmi2Causality.parameter,
                                        variability=Fmi2Variability.fixed))

    def tyre(self, slip, load):
        return self.mu * load * tanh(self.stiffness * slip)

    def do_step(self, current_time, step_size):
        steps = max(1, round(step_size / STEP))
        h = step_size / steps
        wheelbase = self.l_f + self.l_r
        load_f = self.mass * GRAVITY * self.l_r / wheelbase
        load_r = self.mass * GRAVITY * self.l_f / wheelbase
        for _ in range(steps):
            v = max(self.v_x, 0.3)
            force_f = self.tyre(self.delta - atan2(self.v_y + self.l_f * self.omega_z, v), load_f)
            force_r = self.tyre(-atan2(self.v_y - self.l_r * self.omega_z, v), load_r)
            side = force_f * cos(self.delta)
            v_x = self.a - force_f * sin(self.delta) / self.mass + self.omega_z * self.v_y
            v_y = (side + force_r) / self.mass - self.omega_z * self.v_x
            omega = (self.l_f * side - self.l_r * force_r) / self.inertia
            self.x += h * (self.v_x * cos(self.psi) - self.v_y * sin(self.psi))
            self.y += h * (self.v_x * sin(self.psi) + self.v_y * cos(self.psi))
            self.psi = (self.psi + h * self.omega_z + pi) % (2 * pi) - pi
            self.v_x += h * v_x
            self.v_y += h * v_y
            self.omega_z += h * omega
            if self.a <= 0.0 and self.v_x <= 0.0:
                # The brake holds the car, it does not drive it backwards.
                self.v_x = self.v_y = self.omega_z = 0.0
        return True
