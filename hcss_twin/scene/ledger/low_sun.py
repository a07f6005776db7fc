"""Sunlight that a radiance model does without once the sun is very low."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import ProviderError
from hcss_twin.providers import Sun
from hcss_twin.scene.building.assembly import Assembly
from hcss_twin.scene.ledger.entry import Skipped
from hcss_twin.scene.ledger.few_columns import ROOM, FewColumns

Array = NDArray[np.float64]

LOW_SUN_DEG = 88.0
"""Zenith angle of the sun up to which light scattered along its path is known to the models that have it."""

HIGHER_DEG = 1.0
"""So much higher it is known along steep paths, from whose points the sun's zenith angle differs."""

HIGH_DEG = 60.0
"""Zenith angle of the sun up to which it is known along all paths."""


def low_sun(
    assembly: Assembly,
    columns: FewColumns,
    known: Mapping[tuple[float, Sun | None], Mapping[str, Array]],
) -> Iterator[Skipped]:
    """Yield the terms of sunlight that are gone under the lowest sun, though a higher one has them.

    They fade as the sun sets: those of the next higher sun that has them, at 87 degrees for steep views, are the most
    that is lost, relative to the darker columns of the lowest sun.

    Parameters
    ----------
    known : mapping of (float, Sun or None) to mapping of str to ndarray (C, B)
        Terms of the columns at some times with their sun, among which is the lowest.
    """
    suns = {sun: terms for (_, sun), terms in known.items() if sun is not None}
    if not suns:
        return
    lowest = max(suns, key=lambda sun: sun.zenith_deg)
    terms = suns[lowest]
    gone = [name for name in assembly.model.solar_terms if not np.any(terms[name])]
    if lowest.zenith_deg <= HIGH_DEG or not gone:
        return
    what, missing = "sunlight of a very low sun", ", ".join(sorted(gone))
    higher, sun = terms, lowest
    for zenith_deg in np.arange(min(LOW_SUN_DEG, lowest.zenith_deg) - HIGHER_DEG, HIGH_DEG - 1.0, -3.0):
        sun = Sun(float(zenith_deg), lowest.azimuth_deg, lowest.distance_au)
        try:
            higher = columns.terms(assembly.model, sun)
        except ProviderError:
            continue
        # Along slant paths it is gone the sooner.
        if any(np.any(higher[name]) for name in gone):
            break
    total = np.sum(list(terms.values()), axis=0)
    lost = np.sum([higher[name] for name in gone], axis=0)
    if np.any(lost):
        yield Skipped(
            what,
            f"the radiance model has no {missing} with the sun beyond {LOW_SUN_DEG:g} deg from the zenith of any point "
            f"seen; the bound is for {sun.zenith_deg:g} deg",
            ROOM * float(np.max(lost[total > 0.0] / total[total > 0.0], initial=0.0)),
        )
