#!/bin/sh
# Makes docs/ into a book (HTML): target/book/index.html. Needs mdbook (cargo install --locked mdbook).
# mdbook reads \( \) and \[ \] as mathematics; the pages use $ and $$, as GitHub does, so they are translated in a copy, which has the scenarios and
# scripts that they link, too. Fails if a link of the book leads nowhere.
set -eu
cd "$(dirname "$0")/.."
target=${1:-target/book}
case $target in /*) ;; *) target=$PWD/$target ;; esac
command -v mdbook > /dev/null || { echo "$0: no mdbook, first: cargo install --locked mdbook" >&2; exit 1; }
copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
cp -r docs "$copy/docs"
find "$copy/docs" -name '*.md' -exec python3 scripts/book_math.py "$copy/docs" "$PWD" {} +
mdbook build "$copy/docs" --dest-dir "$target"
python3 scripts/book_links.py "$target"
echo "$target/index.html"
