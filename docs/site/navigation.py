"""Navigation of the site from the links of docs/index.md: each second-level heading is a part, its list the pages.

The front page stays plain Markdown, and the order of pages stands in one place.
"""

import re
from collections.abc import Iterator
from typing import Any

HEADING = re.compile(r"^## (.+)$")
LINK = re.compile(r"^\* \[(.+?)\]\((\S+?)\.md\)")


def parts(text: str) -> Iterator[tuple[str, list[str]]]:
    """Heading and entries of the tree, ``title <page>`` relative to the index, of each part that lists any."""
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
    """Give the front page the tree of all pages."""
    if name == app.config.root_doc:
        for heading, pages in parts(source[0]):
            tree = ["", "```{toctree}", ":hidden:", f":caption: {heading}", "", *pages, "```", ""]
            source[0] += "\n".join(tree)


def setup(app: Any) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.connect("source-read", add_navigation)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
