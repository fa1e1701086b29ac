#!/bin/sh
# Prints what fmu/tests/host/race.c needs to know of the FMUs in a folder: both tokens and the value
# references, in the order of its `struct references`. usage: tools/fmu_references.sh out/fmu
set -eu
fmus=${1:-out/fmu}
controller=$(unzip -p "$fmus/fmi2/lmpc-controller.fmu" modelDescription.xml)
vehicle=$(unzip -p "$fmus/fmi2/lmpc-vehicle.fmu" modelDescription.xml)
token() { echo "$1" | sed -n 's/.* guid="\([^"]*\)".*/\1/p'; }
reference() { # description, names: with the FMI 2.0 description, as both versions have the same
    xml=$1
    shift
    for name in "$@"; do
        found=$(echo "$xml" | sed -n "s/.*name=\"$name\" valueReference=\"\([0-9]*\)\".*/\1/p")
        [ -n "$found" ] || { echo "$fmus: no variable '$name'" >&2; exit 1; }
        echo "$found"
    done
}
state="vehicle.v_x vehicle.v_y vehicle.omega_z vehicle.e_psi vehicle.s vehicle.e_y"
token "$controller"
token "$vehicle"
# shellcheck disable=SC2086 # one word per name
reference "$controller" $state cmd.a cmd.delta param.warm_up.laps status.action lap.finished
# shellcheck disable=SC2086
reference "$vehicle" $state cmd.a cmd.delta noise.v_x noise.v_y noise.omega_z noise.e_psi noise.s \
    noise.e_y
