#!/bin/sh
# Builds target/lcm/types.jar, from which lcm-spy knows our messages:
#
#   CLASSPATH=target/lcm/types.jar lcm-spy
#
# Needs lcm-gen, a JDK, and the venv of tools/setup-lcm.sh (for its lcm.jar).
set -eu
cd "$(dirname "$0")/.."
site=$(target/lcm/venv/bin/python -c 'import lcm, os; print(os.path.dirname(os.path.dirname(lcm.__file__)))')
out=target/lcm/jar
rm -rf "$out"
mkdir -p "$out"
lcm-gen --java --jpath "$out" lcm_types/lcm/*.lcm
javac -cp "$site/share/java/lcm.jar" "$out"/lmpc/*.java
jar cf target/lcm/types.jar -C "$out" lmpc
jar tf target/lcm/types.jar | grep -c 'class$' | sed 's/$/ classes in target\/lcm\/types.jar/'
