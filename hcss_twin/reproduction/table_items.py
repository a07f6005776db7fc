"""The tables, and the abstract's numbers."""

from __future__ import annotations

from hcss_twin.reproduction.item import Item


def _item(name: str, title: str, target: str, seconds: float) -> Item:
    return Item(name, title, f"hcss_twin.reproduction.{target}", seconds)


TABLES: tuple[Item, ...] = (
    _item("headline", "Errors claimed in the abstract", "headline:headline", 25.0),
    _item("table-1", "Static scenes: bands and coverages", "table_1:table_1", 2.0),
    _item(
        "table-2",
        "Radiance of static scenes over the view angle",
        "radiance_over_views:table_2",
        25.0,
    ),
    _item(
        "table-2-modtran",
        "MODTRAN's radiance beside Table II",
        "radiance_over_views:table_2_modtran",
        4.0,
    ),
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
        "table-8",
        "Measures of a simulated and a real cloud image: Den, DP, FD and RMSE",
        "tables_8_and_9:table_8",
        3.0,
    ),
    _item("table-8-ev", "Measures of the images of Table VIII: EV", "tables_8_and_9:table_8_entropy", 3.0),
    _item(
        "table-9",
        "Measures of cloud images of three coverages: DP, FD and RMSE",
        "tables_8_and_9:table_9",
        3.0,
    ),
    _item(
        "table-9-ev", "Measures of the images of Table IX: EV and Den", "tables_8_and_9:table_9_entropy", 3.0
    ),
    _item("table-10", "Features of the method", "table_10:table_10", 3.0),
)
