"""FMI 3.0: commands, velocity, rates and pose are arrays; of the rates, yaw is the last, in degrees."""

from math import degrees

import numpy as np
from foreign_vehicle import ForeignVehicle
from pythonfmu3 import Dimension, Fmi3Causality, Fmi3Slave, Fmi3Variability, Float64


class ArrayVehicle(Fmi3Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.car = ForeignVehicle(instance_name="car")
        self.command = np.zeros(2)
        self.velocity, self.angular_velocity = np.array([1.2, 0.0, 0.0]), np.zeros(3)
        self.position, self.euler = np.zeros(3), np.zeros(3)
        self.time = 0.0
        self.register_variable(Float64("time", causality=Fmi3Causality.independent,
                                       variability=Fmi3Variability.continuous))
        for name, size, causality, text in (
            ("command", 2, Fmi3Causality.input, "acceleration and road wheel angle [m/s2, rad]"),
            ("velocity", 3, Fmi3Causality.output, "in the car, y to the left [m/s]"),
            ("angular_velocity", 3, Fmi3Causality.output, "counter-clockwise [deg/s]"),
            ("position", 3, Fmi3Causality.output, "of the centre of mass [m]"),
            ("euler", 3, Fmi3Causality.output, "roll, pitch, yaw, counter-clockwise [rad]"),
        ):
            self.register_variable(Float64(name, causality=causality, description=text,
                                           variability=Fmi3Variability.continuous,
                                           dimensions=[Dimension(start=str(size))]))

    def do_step(self, current_time, step_size):
        car = self.car
        car.a, car.delta = (float(number) for number in self.command)
        car.do_step(current_time, step_size)
        self.velocity = np.array([car.v_x, car.v_y, 0.0])
        self.angular_velocity = np.array([0.0, 0.0, degrees(car.omega_z)])
        self.position, self.euler = np.array([car.x, car.y, 0.0]), np.array([0.0, 0.0, car.psi])
        return True
