#!/bin/sh
# Six vehicles of others, made with PythonFMU and PythonFMU3, each with other names, units and senses and a
# trap of its own (tests/interop/vehicles): the map that `lmpc vehicle inspect` proposes, as `lmpc vehicle
# try` corrects it, drives three learned laps like the same car with its own names. What the map cannot
# know it marks.
set -eu
cd "$(dirname "$0")/../.."
target=$(realpath "${CARGO_TARGET_DIR:-target}")
tools/fmu_tools.sh fmpy
tools/build.sh --quiet
lmpc="$target/release/lmpc --quiet"
tools=$target/tools/fmpy/bin
work=$target/fmu/vehicles
fail() { echo "vehicles: $*" >&2; exit 1; }
rm -rf "$work" && mkdir -p "$work"
cp examples/fmu/foreign_vehicle.py tests/interop/vehicles/*.py "$work/"
# numpy, of which PythonFMU3 makes arrays, for the Python inside the FMU.
PYTHONPATH=$("$tools/python" -c 'import fmpy, os; print(os.path.dirname(os.path.dirname(fmpy.__file__)))')
export PYTHONPATH

# Lap times of a race in which nothing failed.
laps() { # name, FMU, map
    $lmpc race --laps 3 --set warm_up.laps=2 --vehicle "fmu:$2" --map "$3" --out "$work/$1" \
        > "$work/$1.race" || { cat "$work/$1.race" >&2; fail "$1: the race failed"; }
    tail -n +2 "$work/$1/laps.csv" | cut -d, -f4
}
# What a line of a map has to say.
line() { # map, quantity, expected part
    grep "^$2 = " "$1" | grep -qF -e "$3" || {
        cat "$1" >&2
        fail "$1: expected \`$2\` with \`$3\`"
    }
}

(cd "$work" && "$tools/pythonfmu" build -d . -f foreign_vehicle.py > /dev/null)
for name in sae compass wrong_unit silent late; do
    (cd "$work" && "$tools/pythonfmu" build -d . -f $name.py foreign_vehicle.py renamed.py > /dev/null)
done
(cd "$work" && "$tools/pythonfmu3" build -d . -f arrays.py foreign_vehicle.py > /dev/null)
for vehicle in Foreign Sae Compass WrongUnit Silent Late Array; do
    fmu=$work/${vehicle}Vehicle.fmu map=$work/$vehicle.toml tried=$work/$vehicle-tried.toml
    $lmpc vehicle inspect "$fmu" > "$map"
    [ $vehicle != Array ] || {
        # Which element of a command is which, no name says: the map asks for both.
        grep -q '^# a = ?' "$map" && grep -q '^# delta = ?' "$map" || fail "Array: commands guessed"
        sed -i 's/^# a = ?.*/a = "command[0]"/; s/^# delta = ?.*/delta = "command[1]"/' "$map"
    }
    $lmpc check "$map" || fail "$vehicle: the proposed map is refused"
    $lmpc vehicle try "$fmu" --map "$map" --out "$tried" > "$work/$vehicle.tried" ||
        fail "$vehicle: $(cat "$work/$vehicle.tried")"
    laps $vehicle "$fmu" "$tried" > "$work/$vehicle.laps"
done
line "$work/Sae-tried.toml" delta "scale = -1.0"
line "$work/Sae-tried.toml" y "scale = -1.0"
line "$work/Compass-tried.toml" side_slip "sideslip_deg"
line "$work/Compass-tried.toml" psi "offset = 1.57"
line "$work/WrongUnit-tried.toml" v_x "m/s, not km/h"
line "$work/WrongUnit.toml" omega_z "unsure: no unit"
line "$work/WrongUnit-tried.toml" omega_z "scale = 0.0174"
line "$work/Silent.toml" delta "unsure: no unit: taken for SI; its sense is not stated"
line "$work/Silent-tried.toml" delta "scale = -1.0"
line "$work/Silent-tried.toml" v_y "scale = -1.0"
line "$work/Array.toml" omega_z 'variable = "angular_velocity[2]", unit = "deg/s"'
line "$work/Array.toml" x "unsure: elements taken for x, y, z"
# The same car under another name drives the same laps; one with slower actuators, others.
"$tools/python" - "$work" <<'PYTHON'
import pathlib, sys

folder = pathlib.Path(sys.argv[1])
read = lambda name: [float(line) for line in (folder / f"{name}.laps").read_text().split()]
ours = read("Foreign")
for name in ("Foreign", "Sae", "Compass", "WrongUnit", "Silent", "Late", "Array"):
    theirs = read(name)
    assert len(theirs) == 5, (name, theirs)
    apart = max(abs(a / b - 1.0) for a, b in zip(ours, theirs))
    print(f"{name:<10} {' '.join(f'{lap:7.3f}' for lap in theirs)}  {100 * apart:.2f} % apart")
    assert apart < (0.5 if name == "Late" else 0.03), name
    assert min(theirs[2:]) < min(theirs[:2]), f"{name}: no learned lap is faster"
PYTHON
