"""The bicycle of examples/fmu/foreign_vehicle.py under other names, in other units and senses."""

from foreign_vehicle import ForeignVehicle
from pythonfmu import Fmi2Causality, Fmi2Variability, Real


class Renamed(ForeignVehicle):
    """`inputs` are pairs of name and description, `outputs` have a getter in between; `speed` names the
    parameter of the speed at the start."""

    inputs = ()
    speed = "start_speed"

    def outputs(self):
        return ()

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.vars.clear()
        setattr(self, self.speed, 1.2)
        self.mu = 0.85
        for name, text in self.inputs:
            setattr(self, name, 0.0)
            self.register_variable(Real(name, causality=Fmi2Causality.input, description=text))
        for name, getter, text in self.outputs():
            self.register_variable(Real(name, causality=Fmi2Causality.output, getter=getter,
                                        description=text))
        for name in (self.speed, "mu"):
            self.register_variable(Real(name, causality=Fmi2Causality.parameter,
                                        variability=Fmi2Variability.fixed))

    def exit_initialization_mode(self):
        self.v_x = getattr(self, self.speed)
