"""The FMUs that the wheel brings along."""

import pathlib
from typing import Literal

_FOLDER = pathlib.Path(__file__).with_name("fmu_files")


def fmu_path(name: Literal["controller", "vehicle"], fmi: Literal[2, 3] = 3) -> pathlib.Path:
    """File of the controller's or the simulated vehicle's FMU, for FMI 2.0 or 3.0.

    Co-simulation for Linux (x64, ARM64) and Windows. Raises :class:`ValueError` for another name or
    version, :class:`FileNotFoundError` if the package was built without FMUs, as by ``pip install ./python``.
    """
    if name not in ("controller", "vehicle"):
        raise ValueError(f"name {name!r}: expected 'controller' or 'vehicle'")
    if fmi not in (2, 3):
        raise ValueError(f"fmi {fmi!r}: expected 2 or 3")
    path = _FOLDER / f"fmi{fmi}" / f"lmpc-{name}.fmu"
    if not path.exists():
        raise FileNotFoundError(
            f"no {path}: this package was built without FMUs; `make wheel` builds one that has them"
        )
    return path
