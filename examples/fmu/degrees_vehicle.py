"""A car as a vendor might ship it, for PythonFMU to export: the bicycle of `foreign_vehicle.py` with
other names, speeds in km/h, angles in degrees, and steering positive to the right.

    pythonfmu build -f examples/fmu/degrees_vehicle.py -d out/fmu/foreign examples/fmu/foreign_vehicle.py
    lmpc race --vehicle fmu:out/fmu/foreign/DegreesVehicle.fmu --map examples/fmu/degrees_map.toml
"""

from math import degrees, radians

from foreign_vehicle import ForeignVehicle
from pythonfmu import Fmi2Causality, Fmi2Variability, Real


class DegreesVehicle(ForeignVehicle):
    description = "Dynamic bicycle; km/h, degrees, steering positive to the right"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.vars.clear()
        self.accel_request = 0.0
        self.steering_right_deg = 0.0
        self.init_speed_kmh = 4.32
        for name in ("accel_request", "steering_right_deg"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name, getter in [
            ("speed_kmh", lambda: 3.6 * self.v_x),
            ("lateral_velocity_kmh", lambda: 3.6 * self.v_y),
            ("yaw_rate_degps", lambda: degrees(self.omega_z)),
            ("pos_x", lambda: self.x),
            ("pos_y", lambda: self.y),
            ("heading_deg", lambda: degrees(self.psi)),
        ]:
            self.register_variable(Real(name, causality=Fmi2Causality.output, getter=getter))
        self.register_variable(Real("init_speed_kmh", causality=Fmi2Causality.parameter,
                                    variability=Fmi2Variability.fixed))
        self.register_variable(Real("mu", causality=Fmi2Causality.parameter,
                                    variability=Fmi2Variability.fixed))

    def exit_initialization_mode(self):
        self.v_x = self.init_speed_kmh / 3.6

    def do_step(self, current_time, step_size):
        self.a, self.delta = self.accel_request, -radians(self.steering_right_deg)
        return super().do_step(current_time, step_size)
