"""Steps of 16-bit integers for the variables of a cube, chosen from the radiance of a few columns before the run.

Radiance whose range has no limit, or spans bands so unlike that common steps are too coarse for the darkest one, stays
in single precision. If it is compressed, it is rounded to the significant bits that the same share of the accuracy
allows: these errors are relative, so that every band has its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hcss_twin.cube.packing import Packing, packing_of
from hcss_twin.cube.variables import TERM_PREFIX, VariableSpec
from hcss_twin.plan.accuracy import LARGEST_SHARE, RequestedAccuracy, extreme_radiances, relative_slope
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.combinations import Excluded
from hcss_twin.plan.few_columns import SAFETY_FACTOR
from hcss_twin.plan.output import rounded_within
from hcss_twin.plan.waves import wave_bound
from hcss_twin.providers import Sun
from hcss_twin.scenario.scenario import Scenario


@dataclass(frozen=True)
class RadianceRange:
    """Darkest and brightest radiance (B,) that pixels are expected to have."""

    darkest: tuple[float, ...]
    brightest: tuple[float, ...]


def radiance_range(
    scenario: Scenario, assembly: Assembly, suns: Sequence[Sun | None], waves: bool
) -> RadianceRange | None:
    """Return the expected radiances; None without packing or radiance.

    Parameters
    ----------
    suns : sequence of Sun or None
        At some frames; empty without radiance.
    waves : bool
        Whether waves may be resolved.
    """
    if scenario.output.packing is None or not suns:
        return None
    # A shadow is at least as bright as night.
    dark_too = [*suns, None] if assembly.slant.shadows else suns
    darkest, brightest = extreme_radiances(assembly, dark_too)
    margin = SAFETY_FACTOR
    if waves:
        rms = assembly.sea.wave_slope_rms(assembly.grid.pixel_size_m)  # type: ignore[attr-defined]
        margin *= 1.0 + wave_bound(assembly, rms, scenario.sea.wind_from, suns, any_pixel=True)
    return RadianceRange(tuple((darkest / margin).tolist()), tuple((brightest * margin).tolist()))


def widest(ranges: Iterable[RadianceRange | None]) -> RadianceRange | None:
    """Return the range that contains all others."""
    known = [range_ for range_ in ranges if range_ is not None]
    if not known:
        return None
    darkest = np.min([range_.darkest for range_ in known], axis=0)
    brightest = np.max([range_.brightest for range_ in known], axis=0)
    return RadianceRange(tuple(darkest.tolist()), tuple(brightest.tolist()))


def packed_variables(
    variables: tuple[VariableSpec, ...],
    scenario: Scenario,
    assembly: Assembly,
    accuracy: RequestedAccuracy,
    expected: RadianceRange | None,
) -> tuple[tuple[VariableSpec, ...], tuple[str, ...]]:
    """Set the packing of variables according to ``output.packing``, and return notes on radiance that has none.

    Variables without a known range stay in single precision, and so does radiance for which steps are too coarse.

    Raises
    ------
    ScenarioError
        If the same numbers are rounded to significant bits, too.
    """
    if scenario.output.packing is None:
        return variables, ()
    rounded = Excluded("output.quantization", scenario.output.quantization > 0.0, "rounding of the same numbers", "0")
    Excluded.require_none("output.packing = 'int16'", [rounded], "no output.packing")
    packings, notes, result = _Packings(assembly, accuracy, expected), [], []
    for spec in variables:
        packing = packings.of(spec)
        if packing is None and (why := packings.why_not(spec)):
            rest = "output.compression = 1 would round it to the bits that matter"
            if scenario.output.compression:
                spec = rounded_within(spec, LARGEST_SHARE * accuracy.relative)
                rest = f"it is rounded to {spec.significant_bits} bits of the mantissa and compressed"
            notes.append(f"output.packing: {spec.name} stays in single precision, as {why}; {rest}")
        result.append(replace(spec, packing=packing))
    return tuple(result), tuple(notes)


def packing_lines(variables: tuple[VariableSpec, ...], bands: Sequence[str]) -> tuple[str, ...]:
    """Return notes on the packing of variables; empty without."""
    names: dict[str, list[str]] = {}
    for spec in variables:
        if spec.packing is not None:
            errors = [f"error up to {spec.packing.error:.2g}{'' if spec.units == '1' else f' {spec.units}'}"]
            for band, share, kelvin in zip(bands, spec.packing.relative, spec.packing.kelvin, strict=False):
                errors.append(f"{band} {share:.2g} of the radiance, {kelvin:.2g} K")
            names.setdefault(f"16 bits, {'; '.join(errors)}", []).append(spec.name)
        elif spec.dtype == "float32":
            names.setdefault("not packed, as their range is not known or too wide", []).append(spec.name)
    packs = any(spec.packing is not None for spec in variables)
    return tuple(f"{', '.join(variable_names)}: {what}" for what, variable_names in names.items()) if packs else ()


class _Packings:
    def __init__(self, assembly: Assembly, accuracy: RequestedAccuracy, expected: RadianceRange | None) -> None:
        self._assembly, self._accuracy, self._expected = assembly, accuracy, expected
        self._thickest = np.sum(assembly.extreme_thicknesses_m, axis=1).max(initial=1.0)

    def of(self, spec: VariableSpec) -> Packing | None:
        """Return the packing of a variable; None if its range is not known, or its steps would be too coarse."""
        if spec.dtype != "float32" or spec.may_be_missing or spec.kind in ("own", "geometry"):
            return None
        if self._is_radiance(spec):
            packing = None if self._is_boundless(spec) else self._of_radiance(spec)
            return None if packing is None or self._too_coarse(packing) else packing
        if spec.name in ("cloud_thickness", "cloud_layer_thickness"):
            return packing_of(0.0, float(self._thickest))
        return None if spec.lowest is None or spec.highest is None else packing_of(spec.lowest, spec.highest)

    def why_not(self, spec: VariableSpec) -> str:
        """Return why a variable of the radiance has no packing; empty for others."""
        if not self._is_radiance(spec) or spec.may_be_missing:
            return ""
        if self._is_boundless(spec):
            return "the radiance of [[elements]] has no known limit"
        packing = self._of_radiance(spec)
        worst, most = int(np.argmax(packing.relative)), LARGEST_SHARE * self._accuracy.relative
        return (
            f"steps of 16 bits are an error of up to {packing.relative[worst]:.2g} of the radiance "
            f"({packing.kelvin[worst]:.2g} K) in band '{self._assembly.bands[worst].name}', beyond {most:.2g}, "
            f"{100 * LARGEST_SHARE:g} % of the accuracy"
        )

    def _is_radiance(self, spec: VariableSpec) -> bool:
        return self._expected is not None and (spec.kind == "radiance" or spec.name == "brightness_temperature")

    def _is_boundless(self, spec: VariableSpec) -> bool:
        """Whether elements may be brighter than all else; they change no terms."""
        return bool(self._assembly.elements) and not spec.name.startswith(TERM_PREFIX)

    def _too_coarse(self, packing: Packing) -> bool:
        return max(packing.relative) > LARGEST_SHARE * self._accuracy.relative

    def _kelvin(self, radiance: tuple[float, ...]) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        """Return brightness temperatures (B,); beyond the tabulated range, its end."""
        from hcss_twin.models.radiance.brightness_temperature import COLDEST_K, HOTTEST_K, BrightnessTemperature

        black = BrightnessTemperature(self._assembly.spectral_grid, [band.name for band in self._assembly.bands])
        kelvin = black.where_known(np.array(radiance)[:, None])[:, 0].astype(np.float64)
        beyond = np.where(np.array(radiance) > black.highest_radiance, HOTTEST_K, COLDEST_K)
        return np.asarray(np.where(np.isnan(kelvin), beyond, kelvin), dtype=np.float64)

    def _of_radiance(self, spec: VariableSpec) -> Packing:
        """Return the packing with its error in each band."""
        assert self._expected is not None
        darkest, coldest = np.array(self._expected.darkest), self._kelvin(self._expected.darkest)
        slope = np.array(
            [relative_slope(self._assembly.spectral_grid, band, kelvin) for band, kelvin in enumerate(coldest)]
        )
        if spec.units == "K":
            packing = packing_of(float(np.min(coldest)), float(np.max(self._kelvin(self._expected.brightest))))
            kelvin = np.full(darkest.size, packing.error)
            relative = kelvin * slope
        else:
            packing = packing_of(0.0, max(self._expected.brightest))
            relative = packing.error / np.maximum(darkest, np.finfo(float).tiny)
            kelvin = relative / slope
        return replace(packing, relative=tuple(relative.tolist()), kelvin=tuple(kelvin.tolist()))
