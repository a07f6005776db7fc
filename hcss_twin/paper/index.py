"""The tables, and the abstract's numbers.

The figures that can be computed.

Everything that can be computed again, and how it is named.
"""

from __future__ import annotations

from collections.abc import Sequence

from hcss_twin.core.errors import HcssError, choose_from
from hcss_twin.paper.item import Item


def _item(name: str, title: str, target: str, seconds: float) -> Item:
    return Item(name, title, f"hcss_twin.paper.{target}", seconds)


TABLES: tuple[Item, ...] = (
    _item("headline", "Errors claimed in the abstract", "headline:headline", 25.0),
    _item("table-1", "Static scenes: bands and coverages", "table_1:table_1", 2.0),
    _item("table-2", "Radiance of static scenes over the view angle", "radiance_over_views:table_2", 25.0),
    _item("table-2-modtran", "MODTRAN's radiance beside Table II", "radiance_over_views:table_2_modtran", 4.0),
    _item("table-3", "Shape parameters and heights of cloud types", "table_3:table_3", 1.0),
    _item(
        "table-4",
        "Radiance of dynamic scenes over the view angle, 3-5 and 8-14 um",
        "radiance_over_views:table_4",
        25.0,
    ),
    _item(
        "table-4-modtran",
        "MODTRAN's radiance beside Table IV, 3-5 and 8-14 um",
        "radiance_over_views:table_4_modtran",
        4.0,
    ),
    _item(
        "table-4-swir",
        "Radiance of dynamic scenes and MODTRAN's over the view angle, 2.7-3.0 um",
        "radiance_over_views:table_4_short_wave",
        28.0,
    ),
    _item("table-5", "Sun angles and radiance at twenty places", "radiance_over_suns:table_5", 15.0),
    _item("table-6", "Sun angles and radiance over the year", "radiance_over_suns:table_6", 10.0),
    _item("table-7", "Radiance over cloud coverage", "table_7:table_7", 25.0),
    _item(
        "table-8", "Measures of a simulated and a real cloud image: Den, DP, FD and RMSE", "tables_8_and_9:table_8", 3.0
    ),
    _item("table-8-ev", "Measures of the images of Table VIII: EV", "tables_8_and_9:table_8_entropy", 3.0),
    _item("table-9", "Measures of cloud images of three coverages: DP, FD and RMSE", "tables_8_and_9:table_9", 3.0),
    _item("table-9-ev", "Measures of the images of Table IX: EV and Den", "tables_8_and_9:table_9_entropy", 3.0),
    _item("table-10", "Features of the method", "table_10:table_10", 3.0),
)


FIGURES: tuple[Item, ...] = (
    Item(
        "figure-3",
        "Pierson-Moskowitz spectrum at several wind speeds",
        "hcss_twin.paper.figure_03_sea_spectrum:figure_3",
        0.5,
    ),
    Item(
        "figure-4",
        "Fractal fields with different gamma, H, L and kmax",
        "hcss_twin.paper.figure_04_fractal_fields:figure_4",
        4.0,
    ),
    Item("figure-5", "A cloud in three dimensions", "hcss_twin.paper.figure_05_cloud_volume:figure_5", 4.0),
    Item(
        "figure-6",
        "Optical properties of cumulus, stratus and cirrus",
        "hcss_twin.paper.figure_06_cloud_optics:figure_6",
        5.0,
    ),
    Item(
        "figure-9",
        "Static scenes of Table I over view angles",
        "hcss_twin.paper.figure_09_static_scenes:figure_9",
        50.0,
    ),
    Item("figure-10", "Four cloud types over the sea", "hcss_twin.paper.figure_10_cloud_types:figure_10", 8.0),
    Item("figure-11", "One sky in pixels of 5, 20 and 50 m", "hcss_twin.paper.figure_11_resolutions:figure_11", 8.0),
    Item(
        "figure-12", "Stratus in three bands over eight seconds", "hcss_twin.paper.figure_12_push_broom:figure_12", 10.0
    ),
    Item("figure-13", "Coverage from 10 to 50 %", "hcss_twin.paper.figure_13_coverage:figure_13", 8.0),
    Item("figure-14", "Real and simulated cloud image", "hcss_twin.paper.figure_14_cloud_images:figure_14", 4.0),
    Item(
        "figure-15",
        "Transmittance to the detector over wavelength and angle",
        "hcss_twin.paper.figure_15_transmittance:figure_15",
        8.0,
    ),
    Item(
        "figure-16",
        "Mean transmittance to the detector over angle",
        "hcss_twin.paper.figure_15_transmittance:figure_16",
        8.0,
    ),
    Item(
        "figure-17",
        "Degraded image of cirrus in 2.7-3.0 um",
        "hcss_twin.paper.figure_17_degraded_cirrus:figure_17",
        5.0,
    ),
)


ITEMS: tuple[Item, ...] = TABLES + FIGURES

_ROMAN = ("0", "I", "II", "III", "IV", "V", "VI", "VII", "VIII", "IX", "X")


def chosen(names: Sequence[str]) -> tuple[Item, ...]:
    """Return the items of these names in the order of :data:`ITEMS`; all where none is named.

    Raises
    ------
    HcssError
        If there is none of a name; the closest is told.
    """
    known = {item.name: item for item in ITEMS}
    for name in names:
        if name not in known:
            raise HcssError(f"no item '{name}'; {choose_from(name, known)}")
    return tuple(item for item in ITEMS if not names or item.name in names)


def heading(name: str) -> str:
    """Return the name of an item as the paper writes it: ``Table IV, modtran``, ``Figure 12``."""
    kind, *rest = name.split("-")
    if not rest:
        return kind.capitalize()
    number = _ROMAN[int(rest[0])] if kind == "table" and rest[0].isdigit() else rest[0]
    return ", ".join([f"{kind.capitalize()} {number}", *(word.upper() for word in rest[1:])])
