"""The classes lcm-gen made, found in a folder of packages."""

import importlib
import pathlib
import sys


def classes(folder):
    """All message classes below `folder`, by full name."""
    sys.path.insert(0, folder)
    found = {}
    for path in sorted(pathlib.Path(folder).glob("*/*_t.py")):
        package, name = path.parent.name, path.stem
        found[f"{package}.{name}"] = getattr(importlib.import_module(f"{package}.{name}"), name)
    if not found:
        raise SystemExit(f"no generated classes in {folder}")
    return found
