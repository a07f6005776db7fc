"""Fig 3: the Pierson-Moskowitz spectrum at several wind speeds."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from hcss_paper.figure_base import blank
from hcss_paper.inputs import in_words
from hcss_paper.reproduction import Check, Drawing, Reproduction, Row, judged
from hcss_paper.sea_surface import ALPHA, BETA, GRAVITY_M_S2, significant_wave_height_m, spectrum_m2_s
from hcss_twin.providers import Array, Catalog, Kind, SeaInputs
from hcss_twin.providers.registry.registry import Registry

WINDS_M_S = (5.0, 7.5, 10.0, 12.5, 15.0)
Spectrum = Callable[[Array, float], Array]


def figure_3(seed: int, spectrum: Spectrum = spectrum_m2_s) -> Reproduction:
    """Return the spectrum of eq 1, compared with closed forms of its peak and variance, and with the sea model.

    Parameters
    ----------
    seed : int
        Not used.
    spectrum : callable
        Eq 1 as a function of frequencies (N,) in rad/s and wind speed in m/s.
    """
    del seed
    peaks = [_peak_rad_s(spectrum, wind) for wind in WINDS_M_S]
    greatest = [float(spectrum(np.array([peak]), wind)[0]) for peak, wind in zip(peaks, WINDS_M_S, strict=True)]
    heights = [4.0 * math.sqrt(_variance_m2(spectrum, wind)) for wind in WINDS_M_S]
    # d/d omega of eq 1 vanishes at omega^4 = 4/5 beta (g / U)^4, and its integral is alpha U^4 / (4 beta g^2).
    closed_peaks = [(0.8 * BETA) ** 0.25 * GRAVITY_M_S2 / wind for wind in WINDS_M_S]
    closed_heights = [4.0 * math.sqrt(ALPHA / (4.0 * BETA)) * wind**2 / GRAVITY_M_S2 for wind in WINDS_M_S]
    of_model = [_height_of_model_m(wind) for wind in WINDS_M_S]
    # With the printed beta and g, a wave height of U^2 / g (4 alpha / beta)^(1/2) tells alpha.
    alpha = 0.25 * BETA * (of_model[0] * GRAVITY_M_S2 / WINDS_M_S[0] ** 2) ** 2
    rows = [Row("alpha, from the wave height of the sea model", "1", ALPHA, alpha)]
    for wind, peak, height, model in zip(WINDS_M_S, peaks, heights, of_model, strict=True):
        rows += [
            Row(f"{wind:g} m/s, frequency of the peak", "rad s-1", None, peak),
            Row(f"{wind:g} m/s, significant wave height", "m", None, height),
            Row(f"{wind:g} m/s, that of the sea model", "m", None, model),
        ]
    peak_off = _largest_share(peaks, closed_peaks)
    height_off = _largest_share(heights, closed_heights)
    model_off = _largest_share(of_model, heights)
    checks = (
        Check(
            f"frequency of the peak against (4 beta / 5)^(1/4) g / U: {peak_off:.1e} off, at most 1e-6", peak_off < 1e-6
        ),
        Check(
            "wave height 4 m0^(1/2) by quadrature against U^2 / g (4 alpha / beta)^(1/2): "
            f"{height_off:.1e} off, at most 1e-6",
            height_off < 1e-6,
        ),
        Check(f"wave height of the sea model against it: {model_off:.1e} off, at most 1e-6", model_off < 1e-6),
        Check("with more wind the peak is higher", bool(np.all(np.diff(greatest) > 0))),
        Check("with more wind the peak is at a lower frequency", bool(np.all(np.diff(peaks) < 0))),
    )
    return judged(
        rows,
        checks,
        holds="Peak and wave height of eq 1 agree with closed forms and with the sea model.",
        fails="The spectrum is not that of eq 1.",
        chosen=in_words(
            f"wind speeds {', '.join(f'{wind:g}' for wind in WINDS_M_S)} m/s: those of the figure are not stated"
        ),
        notes=(
            f"At 10 m/s the significant wave height is {significant_wave_height_m(10.0):.2f} m, sea state 4 (1.25 "
            "to 2.5 m); the paper calls it sea state 5 (Fig 10).",
        ),
        drawings=(
            Drawing(
                "Pierson-Moskowitz spectrum, eq 1",
                _drawn(spectrum),
                "Five curves of spectral density over frequency: with stronger wind the peak is higher and at a "
                "lower frequency; all have the same tail.",
            ),
        ),
    )


def _height_of_model_m(wind_speed_m_s: float) -> float:
    registry, inputs = Registry.defaults_only(), SeaInputs(wind_speed_m_s, 270.0, 290.0, Catalog())
    return float(registry.create(registry.resolve(Kind.SEA, "cox-munk"), inputs).significant_wave_height_m)


def _drawn(spectrum: Spectrum) -> Figure:
    figure = blank(7.0, 4.2)
    axis = figure.subplots()
    omega = np.linspace(0.2, 3.0, 700)
    for wind in WINDS_M_S:
        axis.plot(omega, spectrum(omega, wind), label=f"{wind:g} m/s", lw=1.4)
    axis.set(xlabel="angular frequency (rad/s)", ylabel="spectrum (m$^2$ s)", xlim=(omega[0], omega[-1]))
    axis.set_ylim(bottom=0.0)
    axis.grid(alpha=0.3)
    axis.legend(title="wind speed")
    return figure


def _peak_rad_s(spectrum: Spectrum, wind: float) -> float:
    def downward(log_omega: float) -> float:
        return -math.log(float(spectrum(np.array([math.exp(log_omega)]), wind)[0]))

    around = math.log(9.81 / wind)
    found = minimize_scalar(downward, bounds=(around - 1.0, around + 1.0), method="bounded", options={"xatol": 1e-10})
    return math.exp(float(found.x))


def _variance_m2(spectrum: Spectrum, wind: float) -> float:
    """Integrate over log frequency, where the spectrum has a single smooth maximum."""
    around = math.log(9.81 / wind)

    def density(log_omega: float) -> float:
        omega = math.exp(log_omega)
        return omega * float(spectrum(np.array([omega]), wind)[0])

    return float(quad(density, around - 3.0, around + 12.0, epsabs=0.0, epsrel=1e-10, limit=200, points=[around])[0])


def _largest_share(found: list[float], expected: list[float]) -> float:
    return float(np.max(np.abs(np.array(found) / np.array(expected) - 1.0)))
