#!/bin/sh
# Fails if a library or program needs a glibc newer than FLOOR or a shared library that is no part
# of glibc; prints what each needs. usage: tools/glibc_floor.sh FLOOR FILE ...
set -eu
floor=$1
shift
[ $# -gt 0 ] || { echo "no file to look at" >&2; exit 2; }
command -v readelf >/dev/null || { echo "readelf is missing: apt-get install binutils" >&2; exit 1; }
bad=0
for file in "$@"; do
    versions=$(readelf --wide -V "$file" | grep -o 'GLIBC_[A-Z0-9._]*' | sort -uV | sed 's/^GLIBC_//')
    [ -n "$versions" ] || { echo "$file: names no glibc version: is it a Linux library?" >&2; exit 1; }
    newest=$(printf '%s\n' "$versions" | tail -1)
    # What is no number (PRIVATE, ABI_DT_RELR) sorts last and exists in newer systems only.
    if [ "$(printf '%s\n%s\n' "$newest" "$floor" | sort -V | tail -1)" != "$floor" ]; then
        echo "$file: needs GLIBC_$newest, newer than $floor" >&2
        bad=1
    fi
    others=$(readelf --wide -d "$file" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' |
        grep -v -E '^(libc|libm|libpthread|libdl|librt|libutil|ld-linux[-a-z0-9_]*)[.]so' || true)
    if [ -n "$others" ]; then
        echo "$file: needs $others" >&2
        bad=1
    fi
    echo "$file: glibc $newest at the least"
done
exit $bad
