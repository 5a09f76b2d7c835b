#!/usr/bin/env python3
"""Checks the links of a built book: every file is there, and so is the place in it. Links to other hosts are left alone.

Usage: book_links.py FOLDER
"""

import html.parser
import pathlib
import sys
import urllib.parse


class Page(html.parser.HTMLParser):
    """Names of places in a page, and what it links."""

    def __init__(self, path):
        super().__init__()
        self.places, self.links = set(), []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.places.update(filter(None, (values.get("id"), values.get("name"))))
        self.links += filter(None, (values.get("href"), values.get("src")))


def main():
    folder = pathlib.Path(sys.argv[1]).resolve()
    # Styles and scripts of mdbook make links for the page that nobody has found.
    pages = {path: Page(path) for path in sorted(folder.rglob("*.html")) if path.name not in ("404.html", "toc.html")}
    faults, n = [], 0
    for path, page in pages.items():
        for link in page.links:
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            n += 1
            target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            place = urllib.parse.unquote(parts.fragment)
            if not target.is_file() and not (target / "index.html").is_file():
                faults.append(f"{path.relative_to(folder)}: {link} leads nowhere")
            elif place and target in pages and place not in pages[target].places:
                faults.append(f"{path.relative_to(folder)}: {link} names no place")
    for fault in faults:
        print(fault, file=sys.stderr)
    print(f"book: {n} links in {len(pages)} pages, {len(faults)} lead nowhere")
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main())
