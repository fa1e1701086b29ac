#!/bin/sh
# Fails, naming what is missing, unless every program named is there.
missing=
for program in "$@"; do
    command -v "$program" >/dev/null 2>&1 || missing="$missing $program"
done
[ -z "$missing" ] && exit 0
echo "missing:$missing; \`tools/setup.sh race test\` installs programs, \`tools/setup-lcm.sh\` target/lcm/venv" >&2
exit 1
