"""Wrong sea models and optics."""

import dataclasses
from dataclasses import replace

import numpy as np
from changed import AZIMUTH, COSINE, FRACTION, WAVENUMBER, Changed, Wrong, argument, on_argument, on_result

BRDF = {
    **{name: FRACTION[name] for name in ("double", "half", "negative", "complement", "percent", "transposed")},
    **{name: FRACTION[name] for name in ("square", "rows-reversed", "first-row", "last-row-lost", "spectrum-reversed")},
    "factor": ("as a reflectance factor, times pi", lambda x: np.pi * x),
    "over-pi": ("divided by pi twice", lambda x: x / np.pi),
    "four": ("with 4 lost from its denominator", lambda x: 4.0 * x),
}


def sea():
    right = "cox-munk-10"
    yield from on_result(right, "emissivity", FRACTION)
    yield from on_argument(right, "emissivity", 0, "wavenumber", WAVENUMBER)
    yield from on_argument(right, "emissivity", 1, "mu", COSINE)
    yield from on_result(right, "brdf", BRDF)
    yield from on_argument(right, "brdf", 0, "wavenumber", WAVENUMBER)
    yield from on_argument(right, "brdf", 1, "mu_out", COSINE)
    yield from on_argument(right, "brdf", 2, "mu_in", COSINE)
    yield from on_argument(right, "brdf", 3, "relative_azimuth", AZIMUTH)
    for name, words, power in (("times-mu", "times the cosine", 1), ("over-mu", "over the cosine", -1)):
        wrap = lambda provider, inputs, power=power: Changed(  # noqa: E731
            provider, brdf=lambda nu, out, into, azimuth: provider.brdf(nu, out, into, azimuth) * into[:, None] ** power
        )
        yield Wrong(f"{right}.brdf.{name}", right, f"brdf is returned {words} of incidence", wrap)
    yield from on_argument("rough-sea", "reflection_weights", 1, "mu", COSINE)
    yield from on_argument(
        "rough-sea", "reflection_weights", 2, "mu_nodes", {n: COSINE[n] for n in ("sine", "complement")}
    )
    weights = {
        "double": ("doubled", lambda x: 2.0 * x),
        "half": ("halved", lambda x: 0.5 * x),
        "complement": ("1 minus it", lambda x: 1.0 - x),
        "exchanged": ("with views and nodes exchanged", lambda x: x.swapaxes(0, 1)),
        "nodes-reversed": ("with nodes in reverse order", lambda x: x[:, ::-1]),
        "even": ("the same for all nodes", lambda x: np.broadcast_to(x.mean(1, keepdims=True), x.shape)),
        "rows-reversed": ("in reverse order", lambda x: x[::-1]),
    }
    yield from on_result("rough-sea", "reflection_weights", weights)
    for name, words, factor in (("percent", "in percent", 100.0), ("root", "as a slope", None)):
        wrap = lambda provider, inputs, factor=factor: Changed(  # noqa: E731
            provider,
            mean_square_slope=factor * provider.mean_square_slope if factor else provider.mean_square_slope**0.5,
        )
        yield Wrong(f"rough-sea.mean_square_slope.{name}", "rough-sea", f"mean_square_slope is {words}", wrap)
    centimetres = lambda provider, inputs: Changed(  # noqa: E731
        provider, significant_wave_height_m=100.0 * provider.significant_wave_height_m
    )
    yield Wrong("rough-sea.wave-height.cm", "rough-sea", "significant_wave_height_m is in cm", centimetres)


PARTICLES = {
    "density-per-cm3": ("number density per cm3", lambda c: replace(c, number_density_m3=1e-6 * c.number_density_m3)),
    "density-per-litre": (
        "number density per litre",
        lambda c: replace(c, number_density_m3=1e-3 * c.number_density_m3),
    ),
    "density-double": ("twice the number density", lambda c: replace(c, number_density_m3=2.0 * c.number_density_m3)),
    "density-half": ("half the number density", lambda c: replace(c, number_density_m3=0.5 * c.number_density_m3)),
    "density-dropped": ("one particle per m3", lambda c: replace(c, number_density_m3=1.0)),
    "scale-double": ("twice the scale b", lambda c: replace(c, b=2.0 * c.b)),
    "scale-half": ("half the scale b", lambda c: replace(c, b=0.5 * c.b)),
    "scale-inverse": ("a length for the scale b", lambda c: replace(c, b=1.0 / c.b)),
    "shape-dropped": ("alpha of 1", lambda c: replace(c, alpha=1.0)),
    "shape-double": ("twice alpha", lambda c: replace(c, alpha=2.0 * c.alpha)),
    "exponent-double": ("twice nu", lambda c: replace(c, nu=2.0 * c.nu)),
    "radius-small": ("radii a tenth", lambda c: replace(c, radius_range_um=tuple(0.1 * r for r in c.radius_range_um))),
    "alpha-for-nu": ("alpha and nu exchanged", lambda c: replace(c, alpha=c.nu, nu=c.alpha)),
}

BULK = {
    "double": ("doubled", lambda x: 2.0 * x),
    "half": ("halved", lambda x: 0.5 * x),
    "negative": ("with the other sign", lambda x: -x),
    "per-km": ("per km", lambda x: 1e3 * x),
    "per-cm": ("per cm", lambda x: 1e-2 * x),
    "per-um": ("per um", lambda x: 1e-6 * x),
    "inverse": ("as a length", lambda x: 1.0 / x),
    "pi": ("without pi", lambda x: x / np.pi),
    "ten": ("ten times", lambda x: 10.0 * x),
    "log10": ("as a decadic coefficient", lambda x: x / np.log(10.0)),
    "reversed": ("with a reversed spectrum", lambda x: x[::-1]),
    "first": ("that of the first wavenumber", lambda x: np.full_like(x, x[0])),
    "square": ("squared", np.square),
}

ALBEDO = {
    "complement": ("1 minus it", lambda x: 1.0 - x),
    "double": ("doubled", lambda x: 2.0 * x),
    "half": ("halved", lambda x: 0.5 * x),
    "negative": ("with the other sign", lambda x: -x),
    "percent": ("in percent", lambda x: 100.0 * x),
    "ratio": ("scattering over absorption", lambda x: x / (1.0 - x)),
    "tenth": ("divided by 10", lambda x: 0.1 * x),
    "reversed": ("with a reversed spectrum", lambda x: x[::-1]),
    "first": ("that of the first wavenumber", lambda x: np.full_like(x, x[0])),
    "zero": ("0", np.zeros_like),
    "one": ("1", np.ones_like),
}


def order(x):
    return np.arange(len(x))[:, None]


MOMENTS = {
    "with-factor": ("with the factor 2k + 1", lambda x: (2 * order(x) + 1) * x),
    "over-factor": ("over the factor 2k + 1", lambda x: x / (2 * order(x) + 1)),
    "alternating": ("of the reversed direction", lambda x: (-1.0) ** order(x) * x),
    "negative": ("with the other sign", lambda x: -x),
    "transposed": ("with exchanged axes", lambda x: x.T),
    "first-lost": ("without the zeroth", lambda x: x[1:]),
    "half": ("halved", lambda x: 0.5 * x),
    "half-but-zeroth": ("halved but the zeroth", lambda x: np.where(order(x) == 0, x, 0.5 * x)),
    "reversed": ("in reverse order", lambda x: x[::-1]),
    "spectrum-reversed": ("with a reversed spectrum", lambda x: x[:, ::-1]),
    "asymmetry-only": ("0 from the second on", lambda x: np.where(order(x) < 2, x, 0.0)),
    "flat": ("1 for all", np.ones_like),
    "linear": ("without squares for the second", lambda x: np.where(order(x) == 2, x[1] ** 2 - 0.5, x)),
    "complement": ("1 minus it, but the zeroth", lambda x: np.where(order(x) == 0, x, 1.0 - x)),
}


def optics():
    right, member = "mie", "single_scattering"
    for part, table in (("extinction_m1", BULK), ("albedo", ALBEDO), ("moments", MOMENTS)):
        yield from on_result(
            right,
            member,
            table,
            pick=lambda value, part=part: getattr(value, part),
            put=lambda value, new, part=part: dataclasses.replace(value, **{part: new}),
            label=part,
        )
    yield from on_argument(right, member, 0, "particles", {n: (f"with {w}", c) for n, (w, c) in PARTICLES.items()})
    yield from on_argument(right, member, 1, "wavenumber", WAVENUMBER)
    other = {"water": "ice", "ice": "water"}
    phase = argument(member, 0, lambda cloud, nu: replace(cloud, material=other[cloud.material]))
    yield Wrong("mie.particles.phase", right, "water is ice and ice is water", phase)
    exchanged = lambda provider, inputs: Changed(  # noqa: E731
        provider, single_scattering=lambda cloud, nu: _exchanged(provider.single_scattering(cloud, nu))
    )
    yield Wrong("mie.exchanged", right, "extinction and albedo are exchanged", exchanged)
    for name, words, change in (
        ("absorption", "absorption for extinction", lambda bulk: bulk.extinction_m1 * (1.0 - bulk.albedo)),
        ("scattering", "scattering for extinction", lambda bulk: bulk.extinction_m1 * bulk.albedo),
    ):
        wrap = lambda provider, inputs, change=change: Changed(  # noqa: E731
            provider,
            single_scattering=lambda cloud, nu: _with_extinction(provider.single_scattering(cloud, nu), change),
        )
        yield Wrong(f"mie.extinction_m1.{name}", right, f"extinction_m1 is {words}", wrap)


def _exchanged(bulk):
    return dataclasses.replace(bulk, extinction_m1=bulk.albedo, albedo=bulk.extinction_m1)


def _with_extinction(bulk, change):
    return dataclasses.replace(bulk, extinction_m1=change(bulk))
