"""Writes tape7 text in MODTRAN's layout, as described in docs/how-to/atmospheres.md; not a test."""

import numpy as np

from hcss_twin.physics.planck import FIRST_RADIATION, SECOND_RADIATION, planck

RADIANCE_NAMES = (
    "TOT_TRANS  PTH_THRML  THRML_SCT  SURF_EMIS   SOL_SCAT  SING_SCAT  GRND_RFLT  DRCT_RFLT  TOTAL_RAD  REF_SOL"
    "  SOL@OBS   DEPTH DIR_EM    TOA_SUN BBODY_T[K]"
)
WIDTHS = (11, 11, 11, 11, 11, 11, 11, 11, 11, 9, 9, 8, 7, 11, 11)


def cards(iemsct, h1_km=100.0, h2_km=0.0, angle_deg=180.0, itype=2, model=6, fwhm=5.0, flag=" "):
    """Echo of the input cards: ten lines."""
    sight = "".join(f"{value:10.5f}" for value in (h1_km, h2_km, angle_deg, 1296.0874, 11.54973, 0.0))
    return [
        f"T F {model}    {itype}    {iemsct}    0    6    6    6    6    6    6    1    0    0   0.000   0.00",
        "    1    1    1    0    0    0  23.00000   0.00000",
        " -99.000 -99.000 -99.000",
        " -99.00000 -99.00000 -99.00000  1.416445  0.000736 ! H2O & O3 COLUMNS [GM/CM2]",
        "   361976 U S STANDARD",
        f"{sight}    0        0.00000",
        "  -99  -99  -99  -99",
        " -99.00000 -99.00000",
        f"{500.0:10.1f}{600.0:10.1f}{1.0:10.1f}{fwhm:10.1f}NW        {flag}",
        "    0   0    0.000  0    0.000  0    1.000",
    ]


def brightness(wavenumber, radiance_w_cm2):
    """Temperature of a black body of a radiance in W cm-2 sr-1 / cm-1."""
    ratio = FIRST_RADIATION * wavenumber**3 / (radiance_w_cm2 * 1e4)
    return SECOND_RADIATION * wavenumber / np.log1p(ratio)


def air(wavenumber, temperature_K=250.0, surface_K=290.0):
    """Transmittance, path and surface radiance (W cm-2 sr-1 / cm-1) of isothermal air over a black surface."""
    tau = 0.2 + 0.6 * (wavenumber - wavenumber[0]) / max(wavenumber[-1] - wavenumber[0], 1.0)
    path = (1.0 - tau) * planck(wavenumber, temperature_K) * 1e-4
    return tau, path, tau * planck(wavenumber, surface_K) * 1e-4


def radiance_rows(wavenumber, tau, path, surface, sun=None, scattered=None, axis=None, scale=None):
    """Rows of IEMSCT 1 (``sun`` None: solar fields 0) or 2 in the fields of tape7; scattered None: blank."""
    sun = np.zeros_like(tau) if sun is None else sun
    scale = np.ones_like(tau) if scale is None else scale
    rows = []
    for at, number in enumerate(wavenumber):
        total = path[at] + surface[at] + sun[at]
        known = None if scattered is None else scattered[at] * scale[at]
        fields = (
            f"{tau[at]:11.8f}",
            f"{path[at] * scale[at]:11.4E}",
            " " * 11 if known is None else f"{known:11.4E}",
            f"{surface[at] * scale[at]:11.4E}",
            f"{sun[at] * scale[at]:11.4E}",
            f"{0.5 * sun[at] * scale[at]:11.4E}",
            f"{0.0:11.4E}",
            f"{0.0:11.4E}",
            f"{total * scale[at]:11.4E}",
            f"{1e-7 * tau[at]:9.2E}",
            f"{9e-8:9.2E}",
            f"{-np.log(tau[at]):8.3f}",
            f"{1.0:7.4f}",
            f"{1e-7:11.4E}",
            f"{brightness(number, total):11.3f}",
        )
        first = f"{number:8.2f}" if axis is None else f"{axis[at]:12.6f}"
        rows.append(first + "".join(fields))
    return rows


def radiance_run(wavenumber, iemsct=1, sun=None, scattered=None, **geometry):
    """Lines of a whole radiance run of :func:`air`."""
    tau, path, surface = air(wavenumber)
    header = "    FREQ  " + RADIANCE_NAMES
    rows = radiance_rows(wavenumber, tau, path, surface, sun, scattered)
    return [*cards(iemsct, **geometry), header, *rows, " -9999."]


def transmittance_run(wavenumber, tau, **geometry):
    """Lines of an IEMSCT 0 run; the last two names touch, as MODTRAN's do."""
    above = "    FREQ COMBIN    H2O   UMIXAER+CLD    -LOG H2-CH4CH4-CH4"
    below = "    CM-1  TRANS  TRANS  TRANS abTRNS  COMBIN  TRANS  TRANS"
    rows = [
        f"{number:8.2f}{t:7.4f}{t:7.4f}{1:7.4f}{1:7.4f}{-np.log(t):8.3f}{1:7.4f}{1:7.4f}"
        for number, t in zip(wavenumber, tau, strict=True)
    ]
    return [*cards(0, **geometry), above, below, *rows, " -9999."]


def write(path, *runs):
    """Write runs one after the other."""
    path.write_text("\n".join(line for run in runs for line in run) + "\n", encoding="ascii")
    return path
