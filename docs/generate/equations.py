"""Page of the equations, from the tables of the plugin hcss-paper."""

from __future__ import annotations

import re
from collections.abc import Iterator

from hcss_paper.equations import ENGINE, PAPER, TITLE, Equation, qualified, summary

PAGE = "development/equations.md"

_INTRODUCTION = f"""# Equations

{{GENERATED}}

Each equation is given in the form in which it is computed, with its source, the function that computes it, and the
first line of that function's documentation. The first part lists the numbered equations of the paper ({TITLE}),
the other parts those of the default models and the engine. If the computation differs from the paper's text, a note
explains how; [as-printed](radiance.md#the-as-printed-model) explains why, and how large the effect is.

Symbols are those of the sources. Units: [conventions](../reference/conventions.md).
"""


def lines(generated: str) -> Iterator[str]:
    """Yield the page."""
    yield _INTRODUCTION.replace("{GENERATED}", generated)
    yield "## The paper's equations\n"
    for equation in PAPER:
        yield from _entry(equation, f"Eq {equation.paper}: {equation.name}", "")
    for part, equations in ENGINE.items():
        yield f"## {part}\n"
        for equation in equations:
            yield from _entry(equation, equation.name, equation.source)


def _entry(equation: Equation, heading: str, source: str) -> Iterator[str]:
    yield f"### {heading}\n"
    yield f"$$\n{equation.formula}\n$$\n"
    for dotted in equation.functions:
        yield f"* `{qualified(dotted)}`: {_plain(summary(dotted))}"
    yield ""
    if source:
        yield f"Source: {source}.\n"
    if equation.note:
        yield f"{equation.note}\n"


def _plain(docstring: str) -> str:
    """Convert one line of a docstring to Markdown: roles and double backquotes become single backquotes."""
    text = re.sub(r":\w+:`~?([^`]+)`", r"`\1`", docstring).replace("``", "`")
    return text.replace("*", r"\*").replace("<", "&lt;").rstrip(":")
