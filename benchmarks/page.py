"""Tables between markers of a page, so that what is printed and what is documented are the same."""

from __future__ import annotations

from pathlib import Path

SPEED = Path(__file__).parents[1] / "docs" / "development" / "accuracy-and-speed.md"


def put(name: str, text: str, page: Path = SPEED) -> None:
    """Replace what stands between ``<!-- name -->`` and ``<!-- end of name -->``.

    Raises
    ------
    ValueError
        If the page has no such markers, once and in this order.
    """
    start, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    whole = page.read_text(encoding="utf-8")
    before, found, rest = whole.partition(start)
    _, closed, after = rest.partition(end)
    if not found or not closed or start in after:
        raise ValueError(f"{page.name} has no single place between {start} and {end}")
    page.write_text(f"{before}{start}\n{text.strip()}\n{end}{after}", encoding="utf-8")
