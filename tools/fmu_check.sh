#!/bin/sh
# Holds the packed FMUs (out/fmu, or the folder named) to what importers that are not ours say:
# validators, bit-equality with the native race, five laps in every tool. Needs python3 with venv
# and pip, xmllint, libtbb12; anything missing is a failure.
set -eu
cd "$(dirname "$0")/.."
fmus=${1:-out/fmu}
tools=${CARGO_TARGET_DIR:-target}/tools
work=${CARGO_TARGET_DIR:-target}/fmu/check
mkdir -p "$work"

tools/fmu_tools.sh
python=$tools/fmpy/bin/python
package=$("$python" -c 'import fmpy, os; print(os.path.dirname(fmpy.__file__))')

echo "== validators"
for version in 2 3; do
    for name in controller vehicle; do
        fmu=$fmus/fmi$version/lmpc-$name.fmu
        "$tools/fmpy/bin/fmpy" validate "$fmu"
        rm -rf "$work/x" && mkdir "$work/x"
        "$python" -m zipfile -e "$fmu" "$work/x"
        xmllint --noout --schema "$package/schema/fmi$version/fmi${version}ModelDescription.xsd" \
            "$work/x/modelDescription.xml"
    done
done
xmllint --noout --schema "$package/schema/fmi3/fmi3TerminalsAndIcons.xsd" \
    "$work/x/terminalsAndIcons/terminalsAndIcons.xml"
ssp=$("$tools/ssp/bin/python" -c 'import pyssp_standard, os; print(os.path.dirname(pyssp_standard.__file__))')/resources
for system in lmpc-race.ssp fmi3/lmpc-race.ssp ssp2/lmpc-race.ssp; do
    rm -rf "$work/x" && mkdir "$work/x"
    "$python" -m zipfile -e "$fmus/$system" "$work/x"
    schemas=$ssp
    [ $system != ssp2/lmpc-race.ssp ] || schemas=$ssp/ssp2
    xmllint --noout --schema "$schemas/SystemStructureDescription.xsd" "$work/x/SystemStructure.ssd"
    xmllint --noout --schema "$schemas/SystemStructureParameterValues.xsd" "$work"/x/resources/*.ssv
    # OMSimulator 3 demands identifiers as names of systems and components.
    if grep -oE '<ssd:(SystemStructureDescription|System|Component)[^>]* name="[^"]*"' \
        "$work/x/SystemStructure.ssd" | sed 's/.* name="//; s/"$//' | grep -vE '^[A-Za-z_][A-Za-z0-9_]*$'; then
        echo "$system: a name that is no identifier" >&2
        exit 1
    fi
done
for version in 2 3; do
    for name in controller vehicle; do
        "$tools/toolbox/bin/fmutool" -input "$fmus/fmi$version/lmpc-$name.fmu" -check \
            > "$work/toolbox.log" 2>&1
        grep "No semantic error against the FMI-$version" "$work/toolbox.log" ||
            { cat "$work/toolbox.log" >&2; exit 1; }
    done
done

echo "== what they ship to be tried with"
"$python" fmu/tests/smoke_test.py "$fmus"

echo "== against lmpc race"
tools/build.sh --quiet
lmpc() { "${CARGO_TARGET_DIR:-target}/release/lmpc" --quiet "$@"; }
lmpc race --seed 0 --laps 5 --out "$work/race" > /dev/null
"$python" fmu/tests/fmpy_lockstep.py "$work/race/trajectory.csv" "$fmus"

echo "== through the fmi crate: step by step, then the car of lmpc race"
"${CARGO_TARGET_DIR:-target}/release/examples/packed_fmus" "$fmus"
# Bit for bit but for the model error: it needs to see into the car.
column=$(head -1 "$work/race/trajectory.csv" | tr , '\n' | grep -nx model_error | cut -d: -f1)
cut -d, -f"$column" --complement "$work/race/trajectory.csv" > "$work/race/seen.csv"
for version in 2 3; do
    lmpc race --laps 5 --vehicle "fmu:$fmus/fmi$version/lmpc-vehicle.fmu" \
        --out "$work/fmu$version" > /dev/null
    cut -d, -f"$column" --complement "$work/fmu$version/trajectory.csv" | cmp - "$work/race/seen.csv"
done
mkdir -p "$work/foreign"
"$tools/fmpy/bin/pythonfmu" build -d "$work/foreign" -f examples/fmu/degrees_vehicle.py \
    examples/fmu/foreign_vehicle.py > /dev/null
# The proposed map and the one checked by hand drive alike; five learned laps, none off the track.
degrees=$work/foreign/DegreesVehicle.fmu
lmpc vehicle inspect "$degrees" > "$work/foreign/map.toml"
lmpc check "$work/foreign/map.toml" examples/fmu/degrees_map.toml
lmpc race --laps 5 --vehicle "fmu:$degrees" --map examples/fmu/degrees_map.toml --out "$work/mapped"
lmpc race --laps 5 --vehicle "fmu:$degrees" --map "$work/foreign/map.toml" --out "$work/proposed" \
    > /dev/null
cmp "$work/mapped/trajectory.csv" "$work/proposed/trajectory.csv"

echo "== five laps in every tool"
rm -rf "$work/laps" && mkdir "$work/laps"
race() { # coupling order, tool, command
    log="$work/laps/$1@$2"
    shift 2
    "$@" > "$log" 2>&1 || { cat "$log"; exit 1; }
}
# A loop of our own or a tool that steps the controller first and the car with the new command; or
# one that steps both and then exchanges.
one="sequential, controller first"
all="parallel, exchange every 0.01 s"
ecos=$tools/ecos/bin/python cosim=$tools/cosim/bin/python pathsim=$tools/pathsim/bin/python
for c in 2 3; do
    for v in 2 3; do
        race "$one" "FMPy, FMI $c controller, $v vehicle" \
            "$python" examples/fmu/race_fmpy.py --fmus "$fmus" --controller $c --vehicle $v
    done
    race "$one" "PathSim, FMI $c" "$pathsim" examples/fmu/race_pathsim.py --fmus "$fmus" --fmi $c
    race "$all" "Ecos, FMI $c" "$ecos" examples/fmu/race_ecos.py --fmus "$fmus" --fmi $c
    race "$all" "Ecos, FMI $c, SSP" "$ecos" examples/fmu/race_ecos.py --fmus "$fmus" --fmi $c --ssp
    race "CoFMUPy's Jacobi loop, 0.01 s" "CoFMUPy, FMI $c" \
        "$tools/cofmupy/bin/python" examples/fmu/race_cofmupy.py --fmus "$fmus" --fmi $c
done
race "$all" "libcosim, FMI 2" "$cosim" examples/fmu/race_libcosim.py --fmus "$fmus"
race "$all" "libcosim, FMI 2, SSP" "$cosim" examples/fmu/race_libcosim.py --fmus "$fmus" --ssp
"$python" examples/fmu/notebook.py > "$work/notebook.log" 2>&1 || { cat "$work/notebook.log"; exit 1; }
mkdir -p "$work/foreign"
"$tools/fmpy/bin/pythonfmu" build -d "$work/foreign" -f examples/fmu/foreign_vehicle.py > /dev/null
race "$one" "foreign vehicle (PythonFMU, FMI 2), FMPy" \
    "$python" examples/fmu/race_foreign.py --fmus "$fmus" --foreign "$work/foreign"
"$python" fmu/tests/race_table.py "$work/laps" 5
