"""Prints the licences of every library that is linked into a program of this workspace.

    python3 tools/licences.py vehicle_bridge [FEATURE ...]

Reads them from the sources that cargo has downloaded. Fails if a library names no licence.
"""

import json
import pathlib
import subprocess
import sys

NAMES = ("license", "licence", "copying", "notice", "unlicense")


def linked(metadata, program):
    """Ids of the packages that are reached from `program` by ordinary dependencies."""
    names = {package["id"]: package["name"] for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    open_ids = [id for id in nodes if names[id] == program]
    found = set(open_ids)
    while open_ids:
        for dep in nodes[open_ids.pop()]["deps"]:
            ordinary = any(kind["kind"] is None for kind in dep["dep_kinds"])
            if ordinary and dep["pkg"] not in found:
                found.add(dep["pkg"])
                open_ids.append(dep["pkg"])
    return found


def main():
    host = next(
        line.split()[1]
        for line in subprocess.run(["rustc", "-vV"], capture_output=True, text=True, check=True)
        .stdout.splitlines()
        if line.startswith("host:")
    )
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", host]
    command += [f"--features={sys.argv[1]}/{feature}" for feature in sys.argv[2:]]
    metadata = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
    reached = linked(metadata, sys.argv[1])
    foreign = [p for p in metadata["packages"] if p["id"] in reached and p["source"]]
    texts = {}
    for package in sorted(foreign, key=lambda p: (p["name"], p["version"])):
        if not (package["license"] or package["license_file"]):
            sys.exit(f"{package['name']} {package['version']} names no licence")
        print(f"{package['name']} {package['version']}: {package['license'] or 'see below'}")
        folder = pathlib.Path(package["manifest_path"]).parent
        for file in sorted(folder.iterdir()):
            if file.is_file() and file.name.lower().startswith(NAMES):
                text = file.read_text(encoding="utf-8", errors="replace").strip()
                texts.setdefault(text, []).append(f"{package['name']} {package['version']}")
    for text, owners in texts.items():
        print(f"\n{'-' * 80}\n{', '.join(owners)}\n\n{text}")


if __name__ == "__main__":
    main()
