"""Feet, miles an hour and thousandths of a radian. The trap: both actuators have a lag of 60 ms."""

from math import exp

from renamed import Renamed

LAG = 0.06


class LateVehicle(Renamed):
    inputs = (
        ("acceleration_request", "[m/s2]"),
        ("steering_request_mrad", "road wheels, positive to the left"),
    )
    speed = "initial_velocity_mph"

    def outputs(self):
        return (
            ("longitudinal_velocity_mph", lambda: self.v_x / 0.44704, ""),
            ("lateral_velocity_mph", lambda: self.v_y / 0.44704, "left positive"),
            ("yaw_velocity_radps", lambda: self.omega_z, "anticlockwise"),
            ("position_x_ft", lambda: self.x / 0.3048, ""),
            ("position_y_ft", lambda: self.y / 0.3048, ""),
            ("yaw_angle_mrad", lambda: 1e3 * self.psi, "anticlockwise"),
        )

    def exit_initialization_mode(self):
        self.v_x = 0.44704 * self.initial_velocity_mph

    def do_step(self, current_time, step_size):
        steps = max(1, round(step_size / 1e-3))
        h = step_size / steps
        reach = 1.0 - exp(-h / LAG)
        for i in range(steps):
            self.a += reach * (self.acceleration_request - self.a)
            self.delta += reach * (1e-3 * self.steering_request_mrad - self.delta)
            super().do_step(current_time + i * h, h)
        return True
