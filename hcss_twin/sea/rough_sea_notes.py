"""What users of the rough sea should know."""

from __future__ import annotations

from hcss_twin.providers import SeaInputs
from hcss_twin.sea.parameters import RoughSeaParameters
from hcss_twin.sea.sea_water import COLD_K, WARM_K
from hcss_twin.sea.slopes import MEASURED_WIND_M_S
from hcss_twin.sea.wave_spectrum import WaveSpectrum

OWN_ERRORS = (
    "sea: emissivity within 0.0004 to 75 deg and 0.004 to 85 deg of rays followed over random surfaces (10.8 um, "
    "winds to 30 m/s)",
)
"""With shadowing and second reflection (docs/sea.md)."""


def notes(inputs: SeaInputs, parameters: RoughSeaParameters, foam: float) -> tuple[str, ...]:
    """Return where laws are extrapolated, and which choices cost what; ``foam`` is its coverage."""
    found = []
    low, high = MEASURED_WIND_M_S
    if not low <= inputs.wind_speed_m_s <= high:
        found.append(
            f"sea: wind {inputs.wind_speed_m_s:g} m/s is outside {low:g} to {high:g} m/s, where Cox and Munk "
            "measured slopes; their laws are extrapolated"
        )
    if parameters.water_temperature and not COLD_K <= inputs.temperature_K <= WARM_K:
        found.append(
            f"sea: water of {inputs.temperature_K:g} K is outside {COLD_K:g} to {WARM_K:g} K; its refractive "
            "index is extrapolated"
        )
    if parameters.shadowing == "none":
        found.append("sea: waves do not hide one another; the BRDF reflects too much toward grazing views")
    if not parameters.re_reflection:
        found.append("sea: no second reflection; emissivity is too low toward grazing views")
    if parameters.slopes != "isotropic":
        found.append("sea: slopes depend on the bearing to the wind; calls without a bearing give the mean")
    if parameters.spectrum == "jonswap" and inputs.wind_speed_m_s > 0.0:
        grown, whole = (
            WaveSpectrum(name, inputs.wind_speed_m_s, parameters.fetch_m).peak_frequency_rad_s
            for name in ("jonswap", "pierson-moskowitz")
        )
        if grown < whole:
            found.append(
                f"sea: after {parameters.fetch_m / 1e3:g} km at {inputs.wind_speed_m_s:g} m/s the sea is fully "
                "developed; JONSWAP lets the waves grow beyond that"
            )
    if foam > 0.1:
        found.append(f"sea: {100 * foam:.0f} % under foam; the coverage law was fitted to less than 10 %")
    return tuple(found)
