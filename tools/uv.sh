#!/bin/sh
# uv with these arguments: it makes Python environments and fills them in a small part of the time of pip. It is
# fetched once, from PyPI. The system's Python serves all of them.
set -eu
version=0.13.8
uv=$(dirname "$0")/../target/tools/uv
[ -z "${CARGO_TARGET_DIR:-}" ] || uv=$CARGO_TARGET_DIR/tools/uv
if [ "$(cat "$uv/ready" 2>/dev/null)" != $version ]; then
    python3 -m venv "$uv"
    "$uv/bin/pip" install --quiet --disable-pip-version-check uv==$version
    echo $version >"$uv/ready"
fi
UV_PYTHON_DOWNLOADS=never exec "$uv/bin/uv" --quiet "$@"
