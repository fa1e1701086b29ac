"""A problem file of the format lmpc-qp-2, which docs/qp_files.md describes."""

import json
import sys

import numpy as np


class Problem:
    """One problem, its arrays as NumPy's; an absent bound is infinite."""

    def __init__(self, path):
        document = json.loads(path.read_text())
        if document["format"] != "lmpc-qp-2":
            sys.exit(f"{path}: the format is {document['format']}, not lmpc-qp-2")
        self.name = path.stem
        self.a = np.array([stage["a"] for stage in document["model"]])
        self.b = np.array([stage["b"] for stage in document["model"]])
        self.c = np.array([stage["c"] for stage in document["model"]])
        self.n, self.points = len(self.a), len(document["hull"])
        for key in ("front", "rear"):
            setattr(self, key, document[key])
        bounds = {"du_max", "speed_max", "front_max", "rear_max"}
        for key, value in document.items():
            if key in ("format", "model", "front", "rear"):
                continue
            if key in bounds:
                many = value if isinstance(value, list) else [value]
                value = [np.inf if v is None else v for v in many]
                value = value if isinstance(document[key], list) else value[0]
            setattr(self, key, np.array(value))
        self.b_now, self.b_before = self.b * (1.0 - self.lag), self.b * self.lag
        self.has_front, self.has_rear = int(np.isfinite(self.front_max)), int(np.isfinite(self.rear_max))
        self.has_speed = int(np.any(np.isfinite(self.speed_max)))

    def box(self, t):
        """Least and greatest inputs of a stage."""
        spared = self.reserve if t > 0 else np.zeros((2, 2))
        return self.u_min + spared[0], self.u_max - spared[1]
