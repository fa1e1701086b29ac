"""Says nothing of units and senses. The trap: steering and lateral velocity are positive to the right."""

from renamed import Renamed


class SilentVehicle(Renamed):
    inputs = (("acc", ""), ("steer", ""))
    speed = "v0"

    def outputs(self):
        return (
            ("vlong", lambda: self.v_x, ""),
            ("vlat", lambda: -self.v_y, ""),
            ("r", lambda: self.omega_z, ""),
            ("px", lambda: self.x, ""),
            ("py", lambda: self.y, ""),
            ("yaw", lambda: self.psi, ""),
        )

    def do_step(self, current_time, step_size):
        self.a, self.delta = self.acc, -self.steer
        return super().do_step(current_time, step_size)
