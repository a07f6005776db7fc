"""Count the words that a user can open: the guide with its reference, and the pages of the plugins.

::

    python docs/generate/words.py [--pages]

A word is text between blanks with a letter or a digit, in prose, tables, code and commands alike. The guide is
README.md and all pages of ``docs/`` but ``docs/development``; ``docs/reference`` is a part of it, and has the text of
``hcss COMMAND --help``. Pages of plugins are the Markdown files in ``plugins/NAME/``. Not counted: pages for developers
(``docs/development``, CONTRIBUTING.md), the change log, docstrings, and tables of results that scripts write
(``plugins/NAME/make``).
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]

MOST = {"guide": 45000, "plugins": 13150}
"""Words that the tests allow: 45 000 of the guide, 62 000 in all."""


def words(path: Path) -> int:
    """Return the number of words of a file."""
    return sum(bool(re.search(r"[A-Za-z0-9]", word)) for word in path.read_text(encoding="utf-8").split())


def pages() -> dict[str, list[Path]]:
    """Return the pages of each kind."""
    docs = ROOT / "docs"
    return {
        "guide": [
            ROOT / "README.md",
            *(
                page
                for page in sorted(docs.rglob("*.md"))
                if page.relative_to(docs).parts[0] not in ("development", "site")
            ),
        ],
        "plugins": sorted(ROOT.glob("plugins/*/*.md")),
    }


def main() -> None:
    """Print the words of each kind, or of each page."""
    for kind, found in pages().items():
        counts = {page: words(page) for page in found}
        print(f"{sum(counts.values()):6d}  {kind}, {len(found)} pages")
        if "--pages" in sys.argv[1:]:
            for page, count in sorted(counts.items(), key=lambda each: -each[1]):
                print(f"{count:6d}    {page.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
