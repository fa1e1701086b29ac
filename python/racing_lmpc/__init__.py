"""Learning model predictive control for autonomous racing.

States are ``[v_x, v_y, omega_z, e_psi, s, e_y]`` with the units ``[m/s, m/s, rad/s, rad, m, m]``,
inputs ``[a, delta]`` with ``[m/s^2, rad]``. Angles, curvature and e_y are positive to the left
(ISO 8855). Where a car, a track or a configuration is expected, a name, a file or a dictionary of
keys will do.
"""

from ._native import (
    Car,
    CarError,
    Config,
    ConfigError,
    Controller,
    ControllerState,
    DataError,
    Error,
    FailureRule,
    LapResult,
    LearnedModel,
    Optimum,
    OptimumError,
    Plan,
    Plant,
    PlantState,
    Race,
    RaceError,
    SafeSet,
    Status,
    Track,
    TrackError,
    __version__,
    optimum,
    race,
)

__all__ = [
    "Car",
    "CarError",
    "Config",
    "ConfigError",
    "Controller",
    "ControllerState",
    "DataError",
    "Error",
    "FailureRule",
    "LapResult",
    "LearnedModel",
    "Optimum",
    "OptimumError",
    "Plan",
    "Plant",
    "PlantState",
    "Race",
    "RaceError",
    "SafeSet",
    "Status",
    "Track",
    "TrackError",
    "__version__",
    "optimum",
    "race",
]
