#!/usr/bin/env python3
"""Translates $...$ and $$...$$ of Markdown pages to what mdbook takes, outside of code; links that leave docs/ become plain text."""

import re
import sys

CODE = re.compile(r"(^```.*?^```\s*?$|`[^`\n]*`)", re.M | re.S)


def escape(formula):
    # Markdown must not see its own signs in a formula.
    return re.sub(r"([\\*_\[\]<>|])", r"\\\1", formula)


def translate(text):
    text = re.sub(r"\$\$(.+?)\$\$", lambda m: "\\\\[" + escape(m[1]) + "\\\\]", text, flags=re.S)
    text = re.sub(r"\$([^$\n]+?)\$", lambda m: "\\\\(" + escape(m[1]) + "\\\\)", text)
    return re.sub(r"\[([^\]]*)\]\((?:\.\./)+([^)]*)\)", lambda m: m[1] if is_outside(m[2]) else m[0], text)


def is_outside(path):
    return path.split("/")[0] in ("scenarios", "scripts", "tests", "crates", "ARCHITECTURE.md", "CONTRIBUTING.md", "README.md")


for name in sys.argv[1:]:
    with open(name, encoding="utf-8") as file:
        parts = CODE.split(file.read())
    with open(name, "w", encoding="utf-8") as file:
        file.write("".join(part if i % 2 else translate(part) for i, part in enumerate(parts)))
