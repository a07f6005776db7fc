"""The certificate of a cube: requested, estimated and achieved error, as numbers and text.

If a fraction p of all pixels exceeds the accuracy, the probability that none of n random pixels does is (1 - p)^n. At
95 % confidence p is therefore below 1 - 0.05^(1/n): under 1 % for n = 300 (C. J. Clopper and E. S. Pearson, *The use
of confidence or fiducial limits illustrated in the case of the binomial*, Biometrika 26, 1934, for no event).

If strata are sampled at different rates, this holds for a pixel drawn in the same way; the fraction of all pixels may
be larger, especially if a large stratum has few samples.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.json_numbers import json_value
from hcss_twin.cube.metadata import AS_SPECIFIED, NOT_AS_SPECIFIED, NOT_CHECKED
from hcss_twin.plan.accuracy import RequestedAccuracy
from hcss_twin.plan.error_budget import ENGINE, ErrorBudget, error_budget
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import pixel_sums
from hcss_twin.providers import CloudLayer

__all__ = ["Certificate"]

Thickness = NDArray[np.float32]

SHADED = "clear in shadow"
PARTS = ("thin", "edge", "thick")
CHOICES = ("low only", "high only", "both")
COUNTS = ("one layer", "two layers", "three layers", "four layers", "five layers")

CONFIDENCE = 0.95


def share_drawn_alike(count: int) -> float:
    """Return the upper limit of the fraction of exceedances among pixels drawn like the checked ones; 1 without any."""
    return float(1.0 - (1.0 - CONFIDENCE) ** (1.0 / count)) if count else 1.0


def share_of_all(pixels: NDArray[np.int64], checked: NDArray[np.int64]) -> float:
    """Return the upper limit of the fraction of exceedances among all pixels if none of the checked ones exceeds.

    It is the largest sum of W p with the product of (1 - p)^n at least 0.05, over strata with a fraction W of all
    pixels and n checked pixels. The method of Lagrange multipliers gives 1 - p = min(1, t n / W), with one t for all
    strata.

    Parameters
    ----------
    pixels, checked : ndarray (S,)
        Number of pixels of each stratum, and of checked ones. A fully checked stratum contributes 0.
    """
    total = int(np.sum(pixels))
    left = checked < pixels
    weight, count = pixels[left] / max(total, 1), checked[left].astype(np.float64)
    unseen = float(np.sum(weight[count == 0]))
    weight, count = weight[count > 0], count[count > 0]
    order = np.argsort(count / weight)
    weight, count = weight[order], count[order]
    rate = count / weight
    for active in range(count.size, 0, -1):
        strata = slice(active)
        ln_t = (np.log(1.0 - CONFIDENCE) - np.sum(count[strata] * np.log(rate[strata]))) / np.sum(count[strata])
        if ln_t + np.log(rate[active - 1]) <= 0.0:
            return unseen + float(np.sum(weight[strata] - np.exp(ln_t) * count[strata]))
    return unseen


DARK_W_M2_SR = 1e-9
"""Band radiance below any detector's sensitivity; its relative error is meaningless."""

DIGITS = 3
"""Significant digits of errors in text: reference sums may differ in the last bits between machines."""


@dataclass(frozen=True)
class StratumCheck:
    """Check of one kind of pixel.

    Attributes
    ----------
    pixels : int
        Pixels of the stratum in the checked frames, including those that cannot be checked.
    checked, exceeding : int
        Number of checked pixels, and of those that exceed the requested error in some band.
    error : tuple of float (B,)
        Largest relative error of each band; empty if no pixel was checked.
    left_out : mapping of str to int
        Number of pixels that the reference cannot compute, by reason.
    """

    name: str
    pixels: int
    checked: int
    exceeding: int
    error: tuple[float, ...]
    left_out: dict[str, int]


@dataclass(frozen=True)
class Certificate:
    """Requested, estimated and achieved error of a cube, relative to the total radiance of the band.

    Attributes
    ----------
    requested : RequestedAccuracy
        Requested accuracy; if it is in kelvin, the verdict uses kelvin.
    estimated : float
        Error estimated by the tables, between their nodes.
    bands : tuple of str (B,)
    strata : tuple of StratumCheck
        Strata with pixels in the checked frames.
    frames : tuple of int
        Checked frames.
    open_share : float
        Largest fraction of the checked frames' pixels above the error, at 95 % confidence, if no checked one is.
    terms : dict of str to float
        Largest error of each term that was looked up, in any band, relative to the total of the band.
    achieved_K : dict
        Largest error of the brightness temperature of each band; empty unless kelvin were requested.
    own_errors : tuple of str
        Provider-stated accuracy, which these errors do not include.
    dark : tuple of str
        Bands in which all checked pixels are darker than ``DARK_W_M2_SR``.
    reference : str
        Whether the reference columns were solved in this run or reused.
    interpolation : str
        What was interpolated between reference columns; empty if nothing was.
    beyond : tuple of str
        Omitted physics that exceeds its share of the accuracy, with its size and the keys that would compute it.
    left_out : tuple of str
        The same of what the user switched off, the plan leaves out for its time, and comes on request.
    budget : ErrorBudget or None
        The total error, models included, by class and band.
    sides : dict
        Light between columns against a reference of its plugin, also as ``text``; empty for independent columns.
    CLEAR : str
        Name of the stratum without cloud.
    NOT_AS_SPECIFIED : str
        First words of the text where a pixel exceeds the requested error.
    """

    CLEAR: ClassVar = "clear"
    NOT_AS_SPECIFIED: ClassVar = NOT_AS_SPECIFIED

    requested: RequestedAccuracy
    estimated: float
    bands: tuple[str, ...]
    strata: tuple[StratumCheck, ...]
    frames: tuple[int, ...]
    open_share: float
    terms: dict[str, float]
    achieved_K: dict[str, float]
    own_errors: tuple[str, ...]
    dark: tuple[str, ...]
    reference: str = "solved in this run"
    interpolation: str = ""
    beyond: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    budget: ErrorBudget | None = None
    sides: dict[str, Any] = field(default_factory=dict)

    @staticmethod
    def stratum_names(layers: int, surfaces: Sequence[str] = (), shadows: bool = False) -> tuple[str, ...]:
        """Return the names (S,) of the strata of a scene, by number.

        Parameters
        ----------
        layers : int
            Number of layers.
        surfaces : sequence of str
            Classes of surface.
        shadows : bool
            Whether clouds cast shadows.
        """
        of_clouds: tuple[str, ...] = (Certificate.CLEAR, *PARTS) if layers == 1 else (Certificate.CLEAR,)
        if layers > 1:
            choices = CHOICES if layers == 2 else COUNTS[:layers]
            of_clouds = (Certificate.CLEAR, *(f"{part} ({choice})" for choice in choices for part in PARTS))
        if shadows:
            of_clouds = (*of_clouds, SHADED)
        return tuple(f"{cloud} over {name}" for name in surfaces for cloud in of_clouds) if surfaces else of_clouds

    @staticmethod
    def stratum_of(
        layers: Sequence[CloudLayer],
        thickness_m: Sequence[Thickness],
        shape: tuple[int, int],
        samples: int,
        shaded: NDArray[np.bool_] | None = None,
    ) -> NDArray[np.int8]:
        """Return the stratum of each pixel of a window (y, x), as an index into :meth:`stratum_names`.

        Parameters
        ----------
        thickness_m : sequence of ndarray (y x samples, x x samples)
            Thickness of each layer at the points of the window. Pixels outside the window are not
            considered in the search for edges.
        shape : (int, int)
            Rows and columns of the window, in pixels.
        samples : int
            Points along each side of a pixel.
        shaded : ndarray of bool (y, x), optional
            Pixels with points in the shadow of clouds.
        """
        layer_choice = np.zeros(shape, dtype=np.int8)
        edge, thick = np.zeros(shape, dtype=np.bool_), np.zeros(shape, dtype=np.bool_)
        for number, (layer, thickness) in enumerate(zip(layers, thickness_m, strict=True)):
            points = _sums(thickness > 0, samples)
            cloudy, full = points > 0, points == samples**2
            layer_choice += np.int8(number + 1 if len(layers) <= 2 else 1) * cloudy
            edge |= cloudy & _at_or_beside(~full)
            middle = math.sqrt(layer.thickness_min_m * layer.thickness_max_m)
            # In a pixel with several points only the cloudy ones count.
            least = middle if samples == 1 else middle * points
            thick |= cloudy & (_sums(thickness, samples) >= least)
        # One byte per pixel, because default numpy integers would take eight times the memory.
        part = np.where(edge, np.int8(1), np.int8(2) * thick.view(np.int8))
        stratum: NDArray[np.int8] = np.where(
            layer_choice > 0, np.int8(3) * layer_choice + (part - np.int8(2)), np.int8(0)
        )
        if shaded is not None:
            stratum[shaded & (stratum == 0)] = len(Certificate.stratum_names(len(layers)))
        return stratum

    @staticmethod
    def budget_of(plan: Plan) -> ErrorBudget:
        """Return the total error of a scene by class and band, with the accuracy that it asks for."""
        return error_budget(plan)

    @property
    def checked(self) -> int:
        """Number of pixels checked."""
        return sum(stratum.checked for stratum in self.strata)

    @property
    def exceeding(self) -> int:
        """Number of checked pixels that exceed the requested error."""
        return sum(stratum.exceeding for stratum in self.strata)

    @property
    def passed(self) -> bool:
        """Whether no checked pixel exceeds the requested error."""
        return self.exceeding == 0

    @property
    def achieved(self) -> dict[str, float]:
        """Largest relative error of each band; empty if nothing was checked."""
        errors = [stratum.error for stratum in self.strata if stratum.checked]
        return dict(zip(self.bands, map(max, zip(*errors, strict=True)), strict=True)) if errors else {}

    @property
    def summary(self) -> tuple[str, ...]:
        """The certificate in a few lines: the verdict, the error, omitted physics, and the total error."""
        error = self._kelvin if self.requested.kelvin is not None else self._relative
        return (self.verdict, f"{error}; reference {self.reference}", *self._omitted, *self._world)

    @property
    def lines(self) -> tuple[str, ...]:
        """The full text of the certificate, the verdict first."""
        checked = ", ".join(f"{stratum.name} {stratum.checked} of {stratum.pixels}" for stratum in self.strata)
        terms = ", ".join(f"{name} {error:.{DIGITS}g}" for name, error in self.terms.items())
        left_out = ", ".join(
            f"{count} {stratum.name} pixels {reason}"
            for stratum in self.strata
            for reason, count in stratum.left_out.items()
            if count
        )
        return (
            self.verdict,
            *((self._kelvin,) if self.requested.kelvin is not None else ()),
            self._relative,
            *((f"error of terms, relative to the total: {terms}",) if terms else ()),
            f"checked pixels of frame{'s' if len(self.frames) > 1 else ''} {', '.join(map(str, self.frames))}: "
            f"{checked or 'none'}",
            *(
                f"band '{band}' is darker than {DARK_W_M2_SR:g} W m-2 sr-1 in all checked pixels: no detector sees "
                "that, and its relative error means little"
                for band in self.dark
            ),
            *((f"not checked, as the reference cannot compute them: {left_out}",) if left_out else ()),
            *((self.interpolation,) if self.interpolation else ()),
            *self._confidence,
            *self._omitted,
            *(f"also omitted: {omission}" for omission in self.beyond[1:]),
            *(f"also left out: {omission}" for omission in self.left_out[1:]),
            "these are the errors of tables, interpolation, streams and spectral grid relative to a reference "
            "that is one level finer, without those of the models",
            *(f"total error, models included: {line}" for line in (self.budget.lines if self.budget else ())),
            *(f"provider-stated accuracy: {stated}" for stated in self.own_errors),
        )

    def as_dict(self) -> dict[str, Any]:
        """Plain values for ``hcss run --json``; non-finite numbers are None."""
        values: dict[str, Any] = {
            "passed": self.passed,
            "requested": self.requested.relative,
            "requested_K": self.requested.kelvin,
            "achieved_K": self.achieved_K,
            "terms": self.terms,
            "own_errors": list(self.own_errors),
            "dark": list(self.dark),
            "within": self.passed and not self.beyond,
            "beyond": list(self.beyond),
            "left_out": list(self.left_out),
            "error_budget": None if self.budget is None else self.budget.as_dict(),
            "reference": self.reference,
            "interpolation": self.interpolation,
            "sides": self.sides,
            "estimated": self.estimated,
            "achieved": self.achieved,
            "pixels": self.checked,
            "frames": list(self.frames),
            "strata": [
                {**vars(stratum), "error": dict(zip(self.bands, stratum.error, strict=False))}
                for stratum in self.strata
            ],
            "text": "; ".join(self.lines),
        }
        return {name: json_value(value) for name, value in values.items()}

    def attributes(self) -> dict[str, str | float | int]:
        """Global attributes of the cube, which do not depend on the cache."""
        plain = self.as_dict()
        return {
            "hcss_certificate": plain["text"],
            "hcss_accuracy_achieved": json.dumps(plain["achieved"]),
            **({"hcss_accuracy_achieved_kelvin": json.dumps(plain["achieved_K"])} if self.achieved_K else {}),
            **({"hcss_certificate_terms": json.dumps(plain["terms"])} if self.terms else {}),
            "hcss_certificate_pixels": self.checked,
            "hcss_certificate_strata": json.dumps(plain["strata"]),
            "hcss_beyond_accuracy": json.dumps(plain["beyond"]),
            "hcss_left_out": json.dumps(plain["left_out"]),
            **({"hcss_error_budget": json.dumps(plain["error_budget"])} if self.budget else {}),
            **({"hcss_monte_carlo": json.dumps(plain["sides"])} if self.sides else {}),
        }

    @property
    def verdict(self) -> str:
        """Whether the cube is computed as specified, with the largest error: the first sentence of the certificate."""
        if not self.checked:
            return f"{NOT_CHECKED}: no pixel of the drawn frames can be computed on the reference path"
        asked = self.requested
        accuracy = f"{asked.kelvin:g} K" if asked.kelvin is not None else f"{100.0 * asked.relative:g} %"
        if self.passed:
            return (
                f"{AS_SPECIFIED}: {self.checked} random pixels, recomputed without tables, differ by at most "
                f"{self._largest} ({accuracy} asked for)"
            )
        worst = ", ".join(
            f"{stratum.name} ({stratum.exceeding} of {stratum.checked}, error up to {max(stratum.error):.{DIGITS}g} in "
            f"{self.bands[int(np.argmax(stratum.error))]})"
            for stratum in self.strata
            if stratum.exceeding
        )
        return (
            f"{NOT_AS_SPECIFIED}: {self.exceeding} of {self.checked} random pixels, recomputed without tables, differ "
            f"by more than the {accuracy} asked for: {worst}"
        )

    @property
    def _largest(self) -> str:
        """The largest error of a checked pixel, also in kelvin where that is known."""
        largest = f"{100.0 * max(self.achieved.values()):.2g} %"
        kelvin = list(self.achieved_K.values()) or [
            contribution.kelvin
            for contributions in (self.budget.contributions.values() if self.budget else ())
            for contribution in contributions
            if contribution.name == ENGINE and contribution.kelvin is not None
        ]
        return f"{largest}, {max(kelvin):.2g} K" if kelvin else largest

    @property
    def _omitted(self) -> tuple[str, ...]:
        sides = (str(self.sides["text"]),) if self.sides else ()
        if self.left_out:
            more = f" (and {len(self.left_out) - 1} more)" if len(self.left_out) > 1 else ""
            sides = (*sides, f"left out, by choice or for the time it takes: {self.left_out[0]}{more}")
        if not self.beyond:
            return sides
        effects = "one omitted effect" if len(self.beyond) == 1 else f"{len(self.beyond)} omitted effects, the largest"
        return (*sides, f"omitted physics is NOT WITHIN the requested accuracy because of {effects}: {self.beyond[0]}")

    @property
    def _world(self) -> tuple[str, ...]:
        return () if self.budget is None else (f"total error, models included: {', '.join(self.budget.totals)}",)

    @property
    def _relative(self) -> str:
        achieved = ", ".join(f"{band} {error:.{DIGITS}g}" for band, error in self.achieved.items())
        return (
            f"relative error of the band radiance: requested {self.requested.relative:.3g}, "
            f"estimated {self.estimated:.2g}, achieved {achieved or 'unknown'}"
        )

    @property
    def _kelvin(self) -> str:
        achieved = ", ".join(f"{band} {error:.{DIGITS}g} K" for band, error in self.achieved_K.items())
        return (
            f"error of the brightness temperature: requested {self.requested.kelvin:g} K, achieved "
            f"{achieved or 'unknown'}"
        )

    @property
    def _confidence(self) -> tuple[str, ...]:
        if not self.checked or not self.passed:
            return ()
        alike, everywhere = (_percent(share) for share in (share_drawn_alike(self.checked), self.open_share))
        return (
            f"at {100 * CONFIDENCE:g} % confidence, less than {alike} of pixels drawn in the same way exceed the "
            f"requested accuracy (1 - 0.05^(1/{self.checked})), and at most {everywhere} of all pixels of the checked "
            "frames do",
        )


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"


def _sums(values: NDArray[Any], samples: int) -> NDArray[Any]:
    return values if samples == 1 else pixel_sums(values, samples)


def _at_or_beside(open_sky: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Pixels in the mask, or adjacent to one in the mask."""
    beside = open_sky.copy()
    beside[1:] |= open_sky[:-1]
    beside[:-1] |= open_sky[1:]
    beside[:, 1:] |= open_sky[:, :-1]
    beside[:, :-1] |= open_sky[:, 1:]
    return beside
