"""A navigation unit: speed over ground, side slip and a compass. The trap: there is no lateral velocity."""

from math import atan2, degrees, hypot

from renamed import Renamed


class CompassVehicle(Renamed):
    inputs = (
        ("accel_g", "demand"),
        ("wheel_angle", "to the left [rad]"),
    )

    def outputs(self):
        return (
            ("speed_over_ground_kmh", lambda: 3.6 * hypot(self.v_x, self.v_y), ""),
            ("sideslip_deg", lambda: degrees(atan2(self.v_y, self.v_x)), "left positive"),
            ("yaw_rate_radps", lambda: -self.omega_z, "clockwise"),
            ("east_m", lambda: self.x, ""),
            ("north_m", lambda: self.y, ""),
            ("heading_deg", lambda: (90.0 - degrees(self.psi)) % 360.0, "clockwise from north"),
        )

    def do_step(self, current_time, step_size):
        self.a, self.delta = 9.80665 * self.accel_g, self.wheel_angle
        return super().do_step(current_time, step_size)
