#!/bin/sh
# Makes Python environments below target/tools: of the importers the FMUs are tested in, of zig, which
# links for an old glibc, and of python, in which our package is built and tested. Without arguments
# those of the importers, otherwise those named: zig python fmpy ecos cosim pathsim ssp toolbox cofmupy.
set -eu
cd "$(dirname "$0")/.."
tools=${CARGO_TARGET_DIR:-target}/tools

for name in ${*:-fmpy ecos cosim pathsim ssp toolbox cofmupy}; do
    alone="" # what is installed without what it asks for
    case $name in
        zig) packages="ziglang==0.17.1 cargo-zigbuild==0.24.1" ;;
        python) packages="maturin==1.16.0 numpy==2.4.6 gymnasium==1.4.0 pytest==9.2.0 mypy==2.4.1 matplotlib==3.11.2 nbclient==0.11.0 ipykernel==7.4.0 distributed==2026.8.0 ray==2.60.0 optuna==5.0.0 fmpy==0.3.32 pyarrow==26.0.1" ;;
        fmpy) packages="fmpy==0.3.32 pythonfmu==0.7.0 pythonfmu3==0.3.4 numpy==2.2.6 matplotlib==3.11.2" ;;
        ecos) packages="ecospy==0.7.2" ;;
        cosim) packages="libcosimpy==0.0.6" ;;
        pathsim) packages="pathsim-fmi==0.1.1" ;;
        ssp) packages="pyssp-standard==0.9.1" ;;
        toolbox) packages="fmu-manipulation-toolbox==2.0" ;;
        # Of what it asks for, what its loop needs. The rest is a page with a server of 2022, for whose demands
        # pip tries versions of everything for minutes.
        cofmupy)
            packages="fmpy==0.3.20 networkx==3.2.1 numpy==2.4.6 pandas==3.1.1 scipy==1.17.1 matplotlib==3.11.2 plotly==7.1.0 confluent-kafka==2.16.1"
            alone="cofmupy==1.0.0"
            ;;
        *) echo "unknown: $name" >&2 && exit 2 ;;
    esac
    [ "$(cat "$tools/$name/ready" 2>/dev/null)" != "$packages$alone" ] || continue
    python3 -m venv "$tools/$name"
    # shellcheck disable=SC2086
    "$tools/$name/bin/pip" install --quiet --disable-pip-version-check $packages
    [ -z "$alone" ] || "$tools/$name/bin/pip" install --quiet --disable-pip-version-check --no-deps "$alone"
    echo "$packages$alone" > "$tools/$name/ready"
done
