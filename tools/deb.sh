#!/bin/sh
# Builds the Debian package of the program for this machine's architecture into out/deb and prints its
# size. LMPC_DEB_BINARY names a program that is built already; LMPC_FEATURES=foxglove adds the server of
# `lmpc view --foxglove`. Needs dpkg-deb and readelf (binutils).
set -eu
cd "$(dirname "$0")/.."
for tool in dpkg-deb readelf python3; do
    command -v "$tool" >/dev/null || { echo "deb: $tool is missing (dpkg, binutils, python3)" >&2; exit 1; }
done

cargo_home=${CARGO_HOME:-$HOME/.cargo}
remap="--remap-path-prefix=$PWD=lmpc --remap-path-prefix=$cargo_home=cargo"
if [ -z "${LMPC_DEB_BINARY:-}" ]; then
    RUSTFLAGS="${RUSTFLAGS:-} $remap" \
        cargo build --quiet --locked --profile dist -p vehicle_bridge --bin lmpc \
        ${LMPC_FEATURES:+--features "$LMPC_FEATURES"}
    LMPC_DEB_BINARY=${CARGO_TARGET_DIR:-target}/dist/lmpc
fi

source=vehicle_bridge/debian
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
architecture=$(dpkg --print-architecture)
package=lmpc_${version}_$architecture
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
# The same source gives the same package.
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || echo 0)}
export SOURCE_DATE_EPOCH

put() { # file, place
    install -D -m 644 "$1" "$root/$2"
}
install -D -s -m 755 "$LMPC_DEB_BINARY" "$root/usr/bin/lmpc"
lmpc=$root/usr/bin/lmpc
put "$source/bridge.env" etc/lmpc/bridge.env
put "$source/sysusers.conf" usr/lib/sysusers.d/lmpc.conf
put vehicle_bridge/systemd/lmpc-bridge.service usr/lib/systemd/system/lmpc-bridge.service
sed -i 's|/usr/local/bin|/usr/bin|; /^# `lmpc bridge` as a service/,/^# `systemctl/c\
# `lmpc bridge` as a service: put the command line of this car into /etc/lmpc/bridge.env, then\
# `systemctl enable --now lmpc-bridge`. /usr/share/doc/lmpc/safety.md, "Watchdog and black box".' \
    "$root/usr/lib/systemd/system/lmpc-bridge.service"

"$lmpc" --quiet man "$root/usr/share/man/man1" >/dev/null
gzip -9n "$root"/usr/share/man/man1/*.1
for shell in bash:bash-completion/completions/lmpc zsh:zsh/vendor-completions/_lmpc \
    fish:fish/vendor_completions.d/lmpc.fish; do
    mkdir -p "$root/usr/share/$(dirname "${shell#*:}")"
    "$lmpc" completions "${shell%%:*}" >"$root/usr/share/${shell#*:}"
done

doc=usr/share/doc/lmpc
put docs/safety.md $doc/safety.md
put CHANGELOG.md $doc/changelog
gzip -9n "$root/$doc/changelog"
{
    printf 'Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\n'
    printf 'Upstream-Name: Racing LMPC\n\nFiles: *\n'
    sed -n 's/^Copyright (c) /Copyright: /p' LICENSE
    printf 'License: Expat\n'
    sed '1,/^Copyright/d; s/^$/./; s/^/ /' LICENSE | sed '1{/^ \.$/d}'
    printf '\nComment: licences of the libraries inside the program: third-party-licences.gz\n'
} >"$root/$doc/copyright"
# shellcheck disable=SC2086 # one word per feature
python3 tools/licences.py vehicle_bridge ${LMPC_FEATURES:-} | gzip -9n >"$root/$doc/third-party-licences.gz"
for folder in bench cars examples/lcm examples/studies examples/tracks; do
    mkdir -p "$root/$doc/examples/${folder##*/}"
    cp -r "$folder/." "$root/$doc/examples/${folder##*/}/"
done
find "$root" -name __pycache__ -prune -exec rm -rf {} +

# The oldest C library that has every symbol of the program.
glibc=$(readelf -V "$lmpc" | grep -o 'GLIBC_[0-9.]*' | sed 's/GLIBC_//' | sort -uV | tail -1)
size=$(du -sk "$root" | cut -f1)
mkdir "$root/DEBIAN"
sed "s/@VERSION@/$version/; s/@ARCHITECTURE@/$architecture/; s/@SIZE@/$size/; s/@GLIBC@/$glibc/" \
    "$source/control.in" >"$root/DEBIAN/control"
echo /etc/lmpc/bridge.env >"$root/DEBIAN/conffiles"
for script in postinst prerm postrm; do
    install -m 755 "$source/$script" "$root/DEBIAN/$script"
done
(cd "$root" && find etc usr -type f ! -path etc/lmpc/bridge.env | LC_ALL=C sort | xargs md5sum >DEBIAN/md5sums)
find "$root" -type d -exec chmod 755 {} +
mkdir -p out/deb
dpkg-deb --root-owner-group -Zxz --build "$root" "out/deb/$package.deb" >/dev/null
echo "out/deb/$package.deb: $(stat -c %s "out/deb/$package.deb") bytes, lmpc itself $(stat -c %s "$lmpc") bytes, glibc $glibc or newer"
