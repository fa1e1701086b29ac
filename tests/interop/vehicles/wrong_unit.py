"""Names that lie: the speed in "km/h" is in m/s, the yaw rate without a unit in degrees a second."""

from math import degrees

from renamed import Renamed


class WrongUnitVehicle(Renamed):
    inputs = (
        ("acceleration_mps2", "demand"),
        ("steering_rad", "road wheels, left positive"),
    )
    speed = "initial_speed_mps"

    def outputs(self):
        return (
            ("velocity_x_kmh", lambda: self.v_x, "forwards"),
            ("velocity_y_mps", lambda: self.v_y, "to the left"),
            ("yawRate", lambda: degrees(self.omega_z), "counter-clockwise"),
            ("posX_m", lambda: self.x, ""),
            ("posY_m", lambda: self.y, ""),
            ("psi_rad", lambda: self.psi, "counter-clockwise"),
        )

    def do_step(self, current_time, step_size):
        self.a, self.delta = self.acceleration_mps2, self.steering_rad
        return super().do_step(current_time, step_size)
