"""Omissions, and the few columns and wavenumbers that bound the radiance change of each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.combinations import NotComputed
from hcss_twin.plan.slant_paths import sea_sun_terms
from hcss_twin.providers import ColumnSetting, RadianceModel, Sun, View
from hcss_twin.providers.column_states import spectra_of

__all__ = ["Omission"]


@dataclass(frozen=True)
class Omission:
    """An omission: what, why, and the largest radiance change it can cause.

    Attributes
    ----------
    bound : float or None
        Relative to the band radiance of any pixel; 0: no change; None: the replacement is equal statistically (or as
        ``why`` says), not pixel by pixel.
    estimate : float or None
        Typical size, where the bound holds for rare pixels only.
    sense : str
        What the estimate means, such as ``98.9 % of the clear pixels``.
    needs : str
        A key and a value that would compute what is omitted, as ``key = value`` or ``key: what is allowed``; or what
        else would, with "no key computes it" at the end; empty if nothing is known that would.
    decision : {"", "switched off", "too dear"}
        Whose decision it is: the user's, or that of the plan for the time that it would take.
    """

    what: str
    why: str
    bound: float | None
    estimate: float | None = None
    sense: str = ""
    needs: str = ""
    decision: str = ""

    @property
    def size(self) -> float | None:
        """The estimate if there is one, else the bound."""
        return self.bound if self.estimate is None else self.estimate

    def exceeds(self, limit: float) -> bool:
        """Whether it would be computed with other keys and may be larger than a limit."""
        largest = self.estimate if self.bound is None else self.bound
        return bool(self.needs) and largest is not None and largest > limit


def omitted(omission: Omission, left_out: NotComputed, instead: str) -> Omission:
    """Return an omission with the reason why an effect is not computed, and what takes its place."""
    decision = SWITCHED_OFF if left_out.switched_off else ""
    return replace(omission, why=f"{left_out.why}: {instead}", needs=left_out.needs, decision=decision)


CROSSED = "mean over the pixels that cloud edges cross"
"""What the error of a pixel that is seen at its centre means."""

SWITCHED_OFF, TOO_DEAR = "switched off", "too dear"
"""Decisions of the user, and of the plan, to leave out what matters."""

SKIP_SHARE = 0.1
"""Share of the accuracy below which the plan skips an effect: some skipped together stay within a third of it."""

OMISSION_SHARE = 0.3
"""Share of the accuracy for each omission: what the tables leave (:data:`hcss_twin.plan.accuracy.SHARES`)."""


PER_BAND = 4
"""Number of wavenumbers per band."""

SAFETY_FACTOR = 1.5
"""Safety factor for columns, wavenumbers and suns between the computed ones."""


@dataclass(frozen=True)
class FewColumns:
    """The clear column and those with the thinnest and thickest clouds, at sampled wavenumbers of each band.

    Attributes
    ----------
    wavenumber_cm1 : ndarray (V,)
    weights_cm1 : ndarray (B, V)
    thickness_m : ndarray (N, L)
        Thickness of the cloudy columns.
    clear : bool
        Whether any pixel can be clear; if not, the clear column is excluded.
    """

    wavenumber_cm1: Array
    weights_cm1: Array
    thickness_m: Array
    clear: bool

    @property
    def ends(self) -> NDArray[np.intp]:
        """Indices of the bounding columns: clear, and the thickest cloud of each layer alone.

        Also the thinnest if there is no clear sky.
        """
        alone = np.count_nonzero(self.thickness_m, axis=1) == 1
        thickest = np.any(self.thickness_m == np.max(self.thickness_m, axis=0, initial=0.0), axis=1)
        chosen = np.flatnonzero(alone & thickest if self.clear else alone)
        return np.concatenate(([0], chosen + 1)) if self.clear else chosen

    def only(self, places: NDArray[np.intp]) -> FewColumns:
        """Return some of the columns by index, with the clear one if it exists."""
        cloudy = places[1:] - 1 if self.clear else places
        return replace(self, thickness_m=self.thickness_m[cloudy])

    def terms_in(self, model: RadianceModel, settings: Sequence[ColumnSetting]) -> list[dict[str, Array]]:
        """Return each term (C, B) of C columns, the clear one first, in some settings that are computed together."""
        clear = np.zeros((int(self.clear), self.thickness_m.shape[1]))
        spectra = spectra_of(model, settings, self.wavenumber_cm1, np.concatenate((clear, self.thickness_m)))
        return [dict(zip(model.terms, np.moveaxis(terms @ self.weights_cm1.T, 1, 0), strict=True)) for terms in spectra]

    def toward(
        self, scene: Assembly, views: Sequence[View], suns: Sequence[Sun | None]
    ) -> Iterator[list[dict[str, Array]]]:
        """Yield, for each view, the terms of the columns under each sun, of which the places of views may have others.

        Views are computed together, unless each has air of its own.
        """
        for some in scene.air_over_field.together(views):
            under = [list(dict.fromkeys(scene.suns_of(view, suns))) for view in some]
            settings = [scene.setting(sun, view) for view, lit in zip(some, under, strict=True) for sun in lit]
            found = iter(self.terms_in(scene.model, settings))
            for lit in under:
                yield [next(found) for _ in lit]

    def totals_in(self, model: RadianceModel, settings: Sequence[ColumnSetting]) -> list[Array]:
        """Return the sum of all terms, (C, B), in each setting."""
        return [np.sum(list(terms.values()), axis=0) for terms in self.terms_in(model, settings)]

    def terms(self, scene: Assembly, sun: Sun | None) -> dict[str, Array]:
        """Return each term (C, B) of the columns of a scene."""
        return self.terms_in(scene.model, [scene.setting(sun)])[0]

    def total(self, scene: Assembly, sun: Sun | None) -> Array:
        """Return the sum of all terms, (C, B)."""
        return self.totals_in(scene.model, [scene.setting(sun)])[0]


def few_columns(assembly: Assembly, per_band: int = PER_BAND) -> FewColumns:
    """Choose the wavenumbers and columns for a scene.

    Each band is divided into equal runs of wavenumbers; the middle one represents its run, with the total weight.
    """
    grid = assembly.spectral_grid
    runs = [
        (band, run)
        for band, weights in enumerate(grid.weights_cm1)
        for run in np.array_split(np.flatnonzero(weights), min(per_band, int(np.count_nonzero(weights))))
    ]
    places, indices = np.unique([run[run.size // 2] for _, run in runs], return_inverse=True)
    summed = np.zeros((grid.weights_cm1.shape[0], places.size))
    for (band, run), index in zip(runs, indices, strict=True):
        summed[band, index] += np.sum(grid.weights_cm1[band, run])
    return FewColumns(grid.wavenumber_cm1[places], summed, assembly.extreme_thicknesses_m, assembly.has_clear_sky)


def largest_contrast(assembly: Assembly, known: Sequence[Mapping[str, Array]]) -> float:
    """Return the largest difference between two pixels of a frame in any band, relative to the darker one.

    Parameters
    ----------
    known : sequence of mapping of str to ndarray (C, B)
        Terms of the columns that bound the scene, the clear one first, under some suns.
    """
    largest = 0.0
    for terms in known:
        total = np.sum(list(terms.values()), axis=0)
        if assembly.slant.shadows and assembly.has_clear_sky:
            in_shadow = total[0] - np.sum([terms[name][0] for name in sea_sun_terms(assembly.model)], axis=0)
            total = np.concatenate((total, in_shadow[None]))
        darkest = np.min(total, axis=0)
        lit = darkest > 0.0
        largest = max(largest, float(np.max(np.max(total, axis=0)[lit] / darkest[lit] - 1.0, initial=0.0)))
    return SAFETY_FACTOR * largest


def typical_contrast(known: Sequence[Mapping[str, Array]]) -> float:
    """Return the largest difference between two columns in any band, relative to their mean; 2 at most."""
    largest = 0.0
    for terms in known:
        total = np.sum(list(terms.values()), axis=0)
        high, low = np.max(total, axis=0), np.min(total, axis=0)
        lit = high > 0.0
        largest = max(largest, float(np.max(2.0 * (high - low)[lit] / (high + low)[lit], initial=0.0)))
    return largest
