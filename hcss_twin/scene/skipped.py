"""What a plan leaves out."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Skipped:
    """Something that is left out, why, and how much radiance it could have carried.

    ``bound`` is relative to the band radiance; 0 means nothing is lost, None that the replacement is
    equal in law (or as ``why`` says) and not pixel by pixel.
    """

    what: str
    why: str
    bound: float | None
