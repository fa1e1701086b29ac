"""SAE J670: x to the north, y to the east, z down. The trap: the world is mirrored, and every angle with it."""

from math import degrees, radians

from renamed import Renamed


class SaeVehicle(Renamed):
    inputs = (
        ("AxCmd", "longitudinal acceleration [m/s2]"),
        ("SteerAngle_deg", "road wheel angle, positive to the right"),
    )
    speed = "InitSpeed_kmh"

    def outputs(self):
        return (
            ("Vx_kmh", lambda: 3.6 * self.v_x, "longitudinal velocity"),
            ("Vy_kmh", lambda: -3.6 * self.v_y, "lateral velocity, positive to the right"),
            ("YawRate_degps", lambda: -degrees(self.omega_z), "clockwise seen from above"),
            ("Xpos_m", lambda: self.x, "NED: north"),
            ("Ypos_m", lambda: -self.y, "NED: east"),
            ("Yaw_deg", lambda: -degrees(self.psi), "clockwise seen from above"),
        )

    def exit_initialization_mode(self):
        self.v_x = self.InitSpeed_kmh / 3.6

    def do_step(self, current_time, step_size):
        self.a, self.delta = self.AxCmd, -radians(self.SteerAngle_deg)
        return super().do_step(current_time, step_size)
