"""A line of the ledger."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Skipped:
    """Something that is left out, why, and how much radiance it could have carried.

    ``bound`` is relative to the band radiance of any pixel; 0 means that nothing is lost, None that what stands in
    its place is equal in law (or as ``why`` says) and not pixel by pixel.
    """

    what: str
    why: str
    bound: float | None
