"""Find resources that a built page would load from other hosts: the site must work without a network."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

LOADED = re.compile(
    r"<(?:script|img|iframe|source|video|audio|embed)\b[^>]*?\b(?:src|srcset)\s*=\s*[\"']?((?:https?:)?//[^\s\"'>]+)"
    r"|<link\b[^>]*?\bhref\s*=\s*[\"']?((?:https?:)?//[^\s\"'>]+)"
    r"|<object\b[^>]*?\bdata\s*=\s*[\"']?((?:https?:)?//[^\s\"'>]+)",
    re.IGNORECASE,
)
LOADED_BY_STYLE = re.compile(r"(?:@import\s+|url\()\s*(?:url\()?[\"']?((?:https?:)?//[^\s\"')]+)", re.IGNORECASE)


def outside(folder: Path) -> Iterator[tuple[str, str]]:
    """Yield each file below a folder with the remote resources it loads; ordinary hyperlinks do not count."""
    for path in sorted(folder.rglob("*")):
        patterns = {".html": (LOADED, LOADED_BY_STYLE), ".css": (LOADED_BY_STYLE,)}.get(path.suffix, ())
        for pattern in patterns:
            for match in pattern.finditer(path.read_text(encoding="utf-8")):
                yield str(path.relative_to(folder)), next(filter(None, match.groups()))


def check(app: Any, exception: Exception | None) -> None:
    """Warn about each remote resource; -W makes this an error."""
    from sphinx.util.logging import getLogger

    if exception is None:
        for page, address in outside(Path(app.outdir)):
            getLogger(__name__).warning("the site needs a network: %s loads %s", page, address)


def setup(app: Any) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.connect("build-finished", check)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
