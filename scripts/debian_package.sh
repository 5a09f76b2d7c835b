#!/bin/sh
# A Debian package of the built program, with manual pages, completions, scenarios and documents.
# Usage: debian_package.sh [FOLDER]; the package goes to FOLDER (target/debian). Needs dpkg-deb, gzip; PROGRAM names another build.
set -eu
cd "$(dirname "$0")/.."
folder=${1:-target/debian}
program=${PROGRAM:-${CARGO_TARGET_DIR:-target}/release/fbimpact}
[ -x "$program" ] || { echo "$0: no $program, first: cargo build --locked --release" >&2; exit 1; }
version=$("$program" --version | sed -n '1s/.* //p')
architecture=$(dpkg --print-architecture)
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
chmod 755 "$root"

install -Dm755 "$program" "$root/usr/bin/fbimpact"
strip --strip-unneeded "$root/usr/bin/fbimpact" 2>/dev/null || true
man=$root/usr/share/man/man1
"$program" man --all "$man" > /dev/null
gzip -9n "$man"/*.1
completions() { mkdir -p "$(dirname "$root/$2")"; "$program" completions "$1" > "$root/$2"; }
completions bash usr/share/bash-completion/completions/fbimpact
completions zsh usr/share/zsh/vendor-completions/_fbimpact
completions fish usr/share/fish/vendor_completions.d/fbimpact.fish

doc=$root/usr/share/doc/fbimpact
mkdir -p "$doc"
cp -r scenarios "$doc/scenarios"
cp -r docs "$doc/docs"
cp README.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE "$doc/"
{
    cat LICENSE; echo
    cat crates/result-files/assets/DejaVuSans.LICENSE; echo
    echo "Figures of reports: uPlot"; cat crates/fbimpact/assets/report/uPlot.LICENSE; echo
    echo "Files of results: HDF5"; cat licenses/HDF5.LICENSE
} > "$doc/copyright"
find "$root" -type d -exec chmod 755 {} +
find "$doc" -type f -exec chmod 644 {} +

# The C library is all that is linked dynamically; what it must have at least stands in the names of its symbols.
glibc=$(objdump -T "$root/usr/bin/fbimpact" | sed -n 's/.*(GLIBC_\([0-9.]*\)).*/\1/p' | sort -V | tail -1)
mkdir "$root/DEBIAN"
cat > "$root/DEBIAN/control" <<CONTROL
Package: fbimpact
Version: $version
Architecture: $architecture
Maintainer: The fbimpact contributors <fbimpact@users.noreply.github.com>
Installed-Size: $(du -sk "$root" | cut -f1)
Depends: libc6 (>= $glibc)$(objdump -p "$root/usr/bin/fbimpact" | grep -q libgcc_s && printf ', libgcc-s1')
Section: science
Priority: optional
Description: impacts in flexible multibody systems
 fbimpact reads a scenario (TOML), builds isogeometric bodies, reduces them,
 finds and refines their contacts, and writes energies, contact forces and
 stresses to HDF5, which is linked statically.
CONTROL
mkdir -p "$folder"
dpkg-deb --root-owner-group --build "$root" "$folder/fbimpact_${version}_$architecture.deb"
