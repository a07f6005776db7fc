"""The figures that can be computed."""

from __future__ import annotations

from hcss_twin.reproduction.item import Item

_ROOM = "hcss_twin.reproduction"

FIGURES: tuple[Item, ...] = (
    Item("figure-3", "Pierson-Moskowitz spectrum at several wind speeds", f"{_ROOM}.figure_03_sea_spectrum:figure_3", 0.5),
    Item("figure-4", "Fractal fields with different gamma, H, L and kmax", f"{_ROOM}.figure_04_fractal_fields:figure_4", 4.0),
    Item("figure-5", "A cloud in three dimensions", f"{_ROOM}.figure_05_cloud_volume:figure_5", 4.0),
    Item("figure-10", "Four cloud types over the sea", f"{_ROOM}.figure_10_cloud_types:figure_10", 8.0),
)
