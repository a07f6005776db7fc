"""The paper's claims about its method: the errors in the abstract and the features of Table X."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hcss_paper.cubes import over_views, scene_inputs
from hcss_paper.fits import column_terms, fitted_mixture
from hcss_paper.inputs import fitted, printed_row, published
from hcss_paper.reproduction import Check, Reproduction, Row, judged, rms_percent
from hcss_paper.scene import BANDS, COLUMNS, black_surface, scene
from hcss_paper.tables_2_and_4 import COVERAGE_CHOICE, MIXTURE_NOTE
from hcss_paper.tables_8_and_9 import cloud_field, eq_24_percent
from hcss_twin import Scenario, simulate
from hcss_twin.providers import Catalog

CLAIMED = {"3.0-5.0": 12.3, "8.0-14.0": 3.7, "shape": 8.3}
"""Percent; abstract and section VI."""

_LARGEST_VIEW_DEG = 60.0
_ROUNDING = 0.05
_LARGEST = 0.5


def headline(seed: int) -> Reproduction:
    """Return the errors that the abstract claims."""
    del seed  # no random numbers are used
    rows: list[Row] = []
    checks: list[Check] = []
    inputs = []
    upto = np.array(published()["view_zenith_deg"]) <= _LARGEST_VIEW_DEG
    for band in (band for band in BANDS if band in CLAIMED):
        name = f"Table IV, {band.replace('.0', '')} um"
        surface = f"MODTRAN surface of {name}"
        inputs.append(surface)
        claimed = CLAIMED[band]
        printed = rms_percent(printed_row("table_4", band)[upto], printed_row("table_4", band, "Modtran")[upto])
        black = black_surface(BANDS[band]).radiance(fitted(surface))[upto]
        found = *(over_views(model, name, band) for model in ("as-printed", "physical")), fitted_mixture()[name]
        ours, physical, mixture = (rms_percent(rows[upto], black) for rows in found)
        rows += [
            Row(f"{band} um, from the printed rows", "%", claimed, printed),
            Row(f"{band} um, from the cubes", "%", claimed, ours, physical, mixture),
        ]
        checks += [
            _close(f"{band} um, rms over 0-60 deg of the printed rows", printed, claimed, _ROUNDING),
            _close(f"{band} um, the same for the cubes", ours, claimed, _LARGEST),
        ]
    table = published()["table_9"]["rows"]
    shapes = [eq_24_percent(table["real"][1:5], table[name][1:5])[1] for name in ("Image1", "Image2", "Image3")]
    mean = float(np.mean(shapes))
    rows += [Row("shape, mean of Table IX's three RMSE", "%", CLAIMED["shape"], mean)]
    checks.append(_close("mean of Table IX's three RMSE", mean, CLAIMED["shape"], _ROUNDING))
    return judged(
        rows,
        checks,
        holds="All three numbers follow from the tables. The notes explain what they measure.",
        fails="The claimed numbers follow from the printed rows, but not all from the cubes, which differ by 4 %: "
        f"{'; '.join(check.statement for check in checks if not check.holds)}.",
        inputs=inputs,
        notes=(
            "12.3 and 3.7 % compare a sunlit scene with thermal runs above a black surface of adjustable "
            "temperature. They measure the difference between the two scenes, not an error of either.",
            "8.3 % includes two images with random cloud masks that served as controls; the image that should "
            f"agree has {shapes[0]:.1f} %.",
            MIXTURE_NOTE,
        ),
        chosen=scene_inputs(COVERAGE_CHOICE),
    )


def _close(what: str, found: float, claimed: float, limit: float) -> Check:
    off = abs(found - claimed)
    return Check(f"{what}: {found:.2f} %, claimed {claimed:g} %, off by at most {limit:.2g}", off <= limit)


RESOLUTIONS_M, COVERAGES = (20.0, 50.0, 100.0), (0.10, 0.50)
"""Resolutions and coverages that section VI claims; 50 m lies between."""
_SIDE_M = 8000.0


def resolutions(seed: int) -> Reproduction:
    """Return the claim of section VI: resolutions of 20 to 100 m and coverages of 10 to 50 %."""
    rows, checks = [], []
    for coverage in COVERAGES:
        means = []
        for pixel_m in RESOLUTIONS_M:
            side = round(_SIDE_M / pixel_m)
            changes = {
                **COLUMNS,
                "image": {"rows": side, "columns": side, "pixel_size": pixel_m},
                "clouds.coverage": coverage,
                "frames.count": 1,
                "output.variables": ["cloud_mask"],
                "output.certificate": 0,
                "seed": seed,
            }
            mask = simulate(Scenario.load("simulated", changes)).cloud_mask[0].to_numpy() > 0
            means.append(mask)
            rows.append(Row(f"{pixel_m:g} m, coverage", "%", 100 * coverage, 100 * float(mask.mean())))
            off, pixel = abs(float(mask.mean()) - coverage), 1.0 / mask.size
            checks.append(
                Check(
                    f"{pixel_m:g} m, coverage {coverage:.0%}: off by {off:.1e}, at most a pixel, {pixel:.1e}",
                    off <= pixel,
                )
            )
        finest, coarsest = means[0].astype(np.float64), means[-1]
        factor = round(RESOLUTIONS_M[-1] / RESOLUTIONS_M[0])
        blocks = finest.reshape(len(coarsest), factor, len(coarsest), factor).mean(axis=(1, 3))
        like = float(np.corrcoef(blocks.ravel(), coarsest.ravel())[0, 1])
        checks.append(
            Check(
                f"coverage {coverage:.0%}: pixels of 100 m show the clouds of 20 m: correlation with their block means "
                f"{like:.2f}, at least 0.8",
                like >= 0.8,
            )
        )
    return judged(
        rows,
        checks,
        holds="Pixels of 20 to 100 m and coverages of 10 to 50 % are simulated, and show the same clouds.",
        fails="A resolution or a coverage is not simulated as requested.",
    )


_CLOUD_TYPES = 4
_BANDS = 3


def table_10(seed: int) -> Reproduction:
    """Return the claims of the column "Proposed Method", each with a check that can fail."""
    return judged(
        [],
        [_mirrors(), _makes_images(seed), _needs_no_data(), _has_terms(), _applies_widely()],
        holds="The table compares features and has no numbers. Its claims for the paper's method hold for this "
        "package.",
        fails="This package lacks a feature that the table claims.",
        notes=("The columns on MODTRAN and deep learning do not concern this package.",),
    )


def _mirrors() -> Check:
    band = list(BANDS).index("3.0-5.0")
    views = published()["view_zenith_deg"]
    day, night = (column_terms().clear(fitted("sea temperature"), scale)[:, band] for scale in (1.0, 0.0))
    peak = views[int(np.argmax(day - night))]
    holds = bool(20 <= peak <= 30 and np.argmax(day) > 0 and np.argmax(night) == 0)
    return Check(
        f"specular reflection: the glint in 3-5 um is brightest at {peak} deg, near the sun's 24.4 deg; without "
        "sunlight the sea is brightest at nadir",
        holds,
        "Table X",
    )


def _makes_images(seed: int) -> Check:
    field = cloud_field("paper-simulated", seed)
    rows, columns = field.shape
    varied = np.unique(field).size
    return Check(
        f"image generation: {rows} x {columns} pixels, {varied} different values",
        varied > rows * columns // 2,
        "Table X",
    )


def _needs_no_data() -> Check:
    used = scene("as-printed", 0.0, (BANDS["3.0-5.0"],), {}).catalog.used
    absolute = [name for name in used if Path(name).is_absolute()]
    return Check(
        f"data dependency: the scene is made from {len(used)} catalog files, none of them an image",
        bool(used) and not absolute and not any(name.endswith((".png", ".tif", ".npy")) for name in used),
    )


def _has_terms() -> Check:
    plan = scene("physical", 20.0, tuple(BANDS.values()), {})
    sunlight = plan.assembly.clear(plan.spectral_grid.wavenumber_cm1, None)
    dark = all(not np.any(sunlight[name]) for name in plan.assembly.model.solar_terms)
    return Check(
        f"physical interpretability: radiance has {len(plan.assembly.model.terms)} named terms, and the "
        f"{len(plan.assembly.model.solar_terms)} that depend on sunlight are 0 without sun",
        dark and len(plan.assembly.model.terms) > 1,
    )


def _applies_widely() -> Check:
    catalog = Catalog()
    types = len(catalog.names("cloud_types", ".toml"))
    airs = len(catalog.names("atmospheres", ".csv"))
    bands = len(catalog.toml(catalog.find("bands", "", ".toml"))["bands"])
    return Check(
        f"applicability: {types} cloud types, {airs} model atmospheres and {bands} bands by name; the paper has "
        f"{_CLOUD_TYPES}, 1 and {_BANDS}",
        types >= _CLOUD_TYPES and airs > 1 and bands >= _BANDS,
    )
