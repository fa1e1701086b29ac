"""From the file to the first step through FMPy, in a new process for each reading.

    python fmu/benches/load.py out/fmu
"""

import statistics
import subprocess
import sys
import tempfile
import time

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

READINGS = 15


def once(path):
    description = fmpy.read_model_description(path)
    with tempfile.TemporaryDirectory() as folder:
        fmpy.extract(path, folder)
        three = description.fmiVersion.startswith("3")
        begin = time.perf_counter()
        fmu = (FMU3Slave if three else FMU2Slave)(
            guid=description.guid or description.instantiationToken, unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier, instanceName="one")
        fmu.instantiate(loggingOn=False)
        if not three:
            fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        print(1e3 * (time.perf_counter() - begin))
        fmu.terminate()
        fmu.freeInstance()


def main():
    if sys.argv[1] == "once":
        once(sys.argv[2])
        return
    for version in "23":
        for name in ("controller", "vehicle"):
            path = f"{sys.argv[1]}/fmi{version}/lmpc-{name}.fmu"
            command = [sys.executable, __file__, "once", path]
            output = [subprocess.run(command, check=True, capture_output=True, text=True).stdout
                      for _ in range(READINGS)]
            times = [float(text) for text in output]
            print(f"{name}, FMI {version}: dlopen, instantiate, initialise: median "
                  f"{statistics.median(times):.2f} ms, longest {max(times):.2f} ms")


if __name__ == "__main__":
    main()
