"""Build the navigation of the site from docs/index.md: each second-level heading is a part, its list the pages.

So the front page is plain Markdown, and the order of pages is defined once.
"""

import re
from collections.abc import Iterator
from typing import Any

HEADING = re.compile(r"^## (.+)$")
LINK = re.compile(r"^\* \[(.+?)\]\((\S+?)\.md\)")


def parts(text: str) -> Iterator[tuple[str, list[str]]]:
    """Yield the heading and the entries (``title <page>``, relative to the index) of each part that lists pages."""
    heading, pages = "", list[str]()
    for line in text.splitlines():
        if match := HEADING.match(line):
            if pages:
                yield heading, pages
            heading, pages = match[1], []
        elif match := LINK.match(line):
            pages.append(f"{match[1]} <{match[2]}>")
    if pages:
        yield heading, pages


def add_navigation(app: Any, name: str, source: list[str]) -> None:
    """Append the tree of all pages to the front page."""
    if name == app.config.root_doc:
        for heading, pages in parts(source[0]):
            tree = ["", "```{toctree}", ":hidden:", f":caption: {heading}", "", *pages, "```", ""]
            source[0] += "\n".join(tree)


def setup(app: Any) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.connect("source-read", add_navigation)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
