#!/usr/bin/env python3
"""Prepares Markdown pages for mdbook: formulas as it takes them, and links that leave the folder of pages.

Usage: book_math.py PAGES ROOT PAGE.md…; PAGES is a copy of docs/, ROOT the checkout.

Translates $...$ and $$...$$ outside of code. Files outside of docs/ that a page links, such as scenarios and scripts, are copied into PAGES under their
paths in the checkout, and the links lead there; of folders and of pages that are not in the book the words stay.
"""

import pathlib
import re
import shutil
import sys

FENCED = re.compile(r"(^```.*?^```\s*?$)", re.M | re.S)
CODE = re.compile(r"(`[^`\n]*`)")
LINK = re.compile(r"(?<!!)\[((?:[^\[\]]|\[[^\[\]]*\])*)\]\(((?:\.\./)+[^)\s]*)\)")


def escape(formula):
    # Markdown must not see its own signs in a formula.
    return re.sub(r"([\\*_\[\]<>|])", r"\\\1", formula)


def formulas(text):
    text = re.sub(r"\$\$(.+?)\$\$", lambda m: "\\\\[" + escape(m[1]) + "\\\\]", text, flags=re.S)
    return re.sub(r"\$([^$\n]+?)\$", lambda m: "\\\\(" + escape(m[1]) + "\\\\)", text)


def link(match, page, pages, root):
    words, (path, _, anchor) = match[1], match[2].partition("#")
    place = page.relative_to(pages).parent
    target = (root / "docs" / place / path).resolve()
    if target.is_relative_to(root / "docs"):
        return match[0]
    if not target.is_file() or target.suffix == ".md":
        return words
    own = target.relative_to(root)
    (pages / own).parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(target, pages / own)
    up = "../" * len(place.parts)
    return f"[{words}]({up}{own.as_posix()}{'#' + anchor if anchor else ''})"


def main():
    pages, root = (pathlib.Path(name).resolve() for name in sys.argv[1:3])
    for name in sys.argv[3:]:
        page = pathlib.Path(name).resolve()
        parts = FENCED.split(page.read_text(encoding="utf-8"))
        for i in range(0, len(parts), 2):
            linked = LINK.sub(lambda m: link(m, page, pages, root), parts[i])
            plain = CODE.split(linked)
            parts[i] = "".join(part if k % 2 else formulas(part) for k, part in enumerate(plain))
        page.write_text("".join(parts), encoding="utf-8")


main()
