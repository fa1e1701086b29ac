"""Runs what each FMU ships by FMI-LS-REF in FMPy: the smoke test, whose outputs must have the bits of
the reference, and for the controller the learned state.

    python fmu/tests/smoke_test.py out/fmu
"""

import csv
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples/fmu"))
from race_fmpy import Fmu  # noqa: E402

FOLDER = "extra/org.fmi-standard.fmi-ls-ref/"


def table(text):
    names, *rows = csv.reader(text.splitlines())
    return names[1:], [[float(cell) for cell in row] for row in rows]


def smoke_test(path, archive, source):
    experiment = ElementTree.fromstring(archive.read(FOLDER + source)).find("Experiment")
    step = float(experiment.get("stepSize"))
    inputs, stimuli = table(archive.read(FOLDER + experiment.find("Stimuli").get("source")).decode())
    outputs, wanted = table(archive.read(FOLDER + experiment.find("References").get("source")).decode())
    wanted = {round(row[0] / step): row[1:] for row in wanted}
    fmu, compared = Fmu(path), 0
    for k, (time, *values) in enumerate(stimuli):
        if k in wanted:
            assert fmu.get(outputs) == wanted[k], f"{path}: {outputs} at {time} s"
            compared += 1
        fmu.set(inputs, values)
        fmu.step(k * step, (k + 1) * step - k * step)
    assert compared >= len(stimuli) - 1, f"{path}: only {compared} rows compared"
    print(f"{path}: smoke test, {compared} rows with the reference's bits")


def learned(path, archive, source):
    fmu = Fmu(path)
    read = fmu.fmu.deserializeFMUState if fmu.three else fmu.fmu.deSerializeFMUstate
    restore = fmu.fmu.setFMUState if fmu.three else fmu.fmu.setFMUstate
    restore(read(archive.read(FOLDER + source)))
    finished = fmu.get(["lap.finished"])[0]
    assert finished >= 5, f"{path}: {finished} laps in {source}"
    print(f"{path}: {source} restored with {finished:.0f} laps")


def main():
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/fmu")
    for version in "23":
        for name in ("controller", "vehicle"):
            path = folder / f"fmi{version}/lmpc-{name}.fmu"
            with zipfile.ZipFile(path) as archive:
                manifest = ElementTree.fromstring(archive.read(FOLDER + "fmi-ls-manifest.xml"))
                roles = {item.get("source"): item.get("role") for item in manifest.iter("Related")}
                for source, role in roles.items():
                    if role == "experiment/smoke-test":
                        smoke_test(path, archive, source)
                    if role == "serialized-state":
                        learned(path, archive, source)
                assert set(roles.values()) >= {"experiment/smoke-test", "parameter", "result"}


if __name__ == "__main__":
    main()
