"""Rotation of the Earth: from frames that do not turn with it to the Earth-fixed frame.

The frame of two-line elements (TEME) needs sidereal time alone; precession and nutation of the others come from ERFA,
the IAU's routines (package pyerfa, extra ``frames``), as do leap seconds.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np

from hcss_payload.checks import PayloadError, require_within
from hcss_twin.providers import Array

EARTH_RATE_RAD_S = 7.292115e-5
"""Rotation rate of the Earth; NIMA TR8350.2 (2000), table 3.1."""

_J2000 = datetime(2000, 1, 1, 12, tzinfo=UTC)
_ARCSECOND = np.pi / 648000.0


@dataclass(frozen=True)
class EarthOrientation:
    """UT1 - UTC and the position of the pole, as in IERS Bulletin A.

    Without dUT1 positions from two-line elements are wrong by up to 420 m at the equator (0.9 s), without polar motion
    by up to 15 m.

    Parameters
    ----------
    dut1_s : float
        UT1 - UTC.
    pole_arcsec : (float, float)
        Coordinates x, y of the pole.
    """

    dut1_s: float = 0.0
    pole_arcsec: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        require_within("orientation.dut1_s", self.dut1_s, -1.0, 1.0, "s")
        for value in self.pole_arcsec:
            require_within("orientation.pole_arcsec", value, -1.0, 1.0, "arc seconds")

    def earth_fixed(self, teme_m: Array, utc_days: float) -> Array:
        """Return a position (3,) of the TEME frame in the Earth-fixed frame, ``utc_days`` after noon of 2000-01-01.

        D. A. Vallado et al., "Revisiting Spacetrack Report #3", AIAA 2006-6753, appendix C: sidereal time of 1982, then
        polar motion.
        """
        angle = sidereal_angle(utc_days + self.dut1_s / 86400.0)
        cosine, sine = np.cos(angle), np.sin(angle)
        x, y, z = cosine * teme_m[0] + sine * teme_m[1], cosine * teme_m[1] - sine * teme_m[0], teme_m[2]
        pole_x, pole_y = (value * _ARCSECOND for value in self.pole_arcsec)
        return np.array([x + pole_x * z, y - pole_y * z, z - pole_x * x + pole_y * y])

    def states(
        self, frame: str, position_m: Array, velocity_m_s: Array | None, utc_days: Sequence[float]
    ) -> tuple[Array, Array | None]:
        """Return positions (N, 3) and velocities (N, 3) over the rotating Earth of those of another frame.

        Parameters
        ----------
        frame : str
            ``TEME`` of date, ``GCRF``, or ``EME2000`` (mean equator and equinox of J2000).

        Raises
        ------
        PayloadError
            If the frame needs the extra ``frames``.
        """
        turns = [self._turn(frame, day) for day in utc_days]
        positions = np.array([turn @ vector for turn, vector in zip(turns, position_m, strict=True)])
        if velocity_m_s is None:
            return positions, None
        turned = np.array([turn @ vector for turn, vector in zip(turns, velocity_m_s, strict=True)])
        return positions, turned - np.cross([0.0, 0.0, EARTH_RATE_RAD_S], positions)

    def _turn(self, frame: str, utc_days: float) -> Array:
        """Return the matrix (3, 3) from a frame to the Earth-fixed one."""
        if frame == "TEME":
            return np.stack([self.earth_fixed(axis, utc_days) for axis in np.eye(3)], axis=1)
        erfa = _erfa(f"positions in {frame}")
        since_tai_s = tai_minus_utc_s(_J2000 + timedelta(days=utc_days))
        terrestrial, universal = utc_days + (since_tai_s + 32.184) / 86400.0, utc_days + self.dut1_s / 86400.0
        pole = (value * _ARCSECOND for value in self.pole_arcsec)
        turn: Array = erfa.c2t06a(2451545.0, terrestrial, 2451545.0, universal, *pole)
        return turn if frame == "GCRF" else turn @ erfa.bp06(2451545.0, 0.0)[0].T


def tai_minus_utc_s(utc: datetime) -> float:
    """Return the leap seconds of a day, TAI - UTC, from 1960 on; later than known, those of the last known day.

    Raises
    ------
    PayloadError
        Without the extra ``frames``.
    """
    erfa = _erfa("leap seconds")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about years for which none is announced yet
        return float(erfa.dat(utc.year, utc.month, utc.day, 0.0))


def _erfa(what: str) -> Any:
    try:
        import erfa  # an extra
    except ModuleNotFoundError as missing:
        raise PayloadError(f"trajectory: {what} need pyerfa: pip install 'hcss-payload[frames]'") from missing
    return erfa


def days_since_2000(utc: datetime) -> float:
    """Return days of 86400 s since noon of 2000-01-01."""
    return (utc - _J2000).total_seconds() / 86400.0


def sidereal_angle(ut1_days: float) -> float:
    """Return Greenwich mean sidereal time in rad for days of UT1 since noon of 2000-01-01.

    S. Aoki et al., "The new definition of universal time", Astronomy and Astrophysics 105, 359-361 (1982), eq 14.
    """
    century = ut1_days / 36525.0
    rest = 67310.54841 + (8640184.812866 + (0.093104 - 6.2e-6 * century) * century) * century
    # 876600 h per century are one turn a day, whose whole turns would cost digits.
    turns = rest / 86400.0 + ut1_days % 1.0
    return float(2.0 * np.pi * (turns % 1.0))
