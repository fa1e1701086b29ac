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
for ssp in "$fmus/lmpc-race.ssp" "$fmus/fmi3/lmpc-race.ssp"; do
    "$python" -m zipfile -e "$ssp" "$work/x"
    xmllint --noout --schema "$package/ssp/schema/SystemStructureDescription.xsd" \
        "$work/x/SystemStructure.ssd"
done

echo "== against the native race"
cargo run --quiet -p fmu_core --example native > "$work/native.txt"
"$python" fmu/tests/fmpy_lockstep.py "$work/native.txt" "$fmus"

echo "== five laps in every tool"
race() {
    echo "-- $*"
    "$@" > "$work/race.log" 2>&1 || { cat "$work/race.log"; exit 1; }
    grep -E '^lap [0-9]+:|laps$|steps, trace' "$work/race.log"
}
for version in 2 3; do
    race "$python" examples/fmu/race_fmpy.py --fmus "$fmus" --controller $version --vehicle $version
    race "$tools/pathsim/bin/python" examples/fmu/race_pathsim.py --fmus "$fmus" --fmi $version
    race "$tools/ecos/bin/python" examples/fmu/race_ecos.py --fmus "$fmus" --fmi $version
done
race "$tools/cosim/bin/python" examples/fmu/race_libcosim.py --fmus "$fmus"
race "$tools/cosim/bin/python" examples/fmu/race_libcosim.py --fmus "$fmus" --ssp
mkdir -p "$work/foreign"
(cd "$work" && "$OLDPWD/$tools/fmpy/bin/pythonfmu" build -d foreign \
    -f "$OLDPWD/examples/fmu/foreign_vehicle.py" > /dev/null)
race "$python" examples/fmu/race_foreign.py --fmus "$fmus" --foreign "$work/foreign"
