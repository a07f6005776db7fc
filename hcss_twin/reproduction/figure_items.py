"""The figures that can be computed."""

from __future__ import annotations

from hcss_twin.reproduction.item import Item

_ROOM = "hcss_twin.reproduction"

FIGURES: tuple[Item, ...] = (
    Item(
        "figure-3",
        "Pierson-Moskowitz spectrum at several wind speeds",
        f"{_ROOM}.figure_03_sea_spectrum:figure_3",
        0.5,
    ),
    Item(
        "figure-4",
        "Fractal fields with different gamma, H, L and kmax",
        f"{_ROOM}.figure_04_fractal_fields:figure_4",
        4.0,
    ),
    Item("figure-5", "A cloud in three dimensions", f"{_ROOM}.figure_05_cloud_volume:figure_5", 4.0),
    Item(
        "figure-6",
        "Optical properties of cumulus, stratus and cirrus",
        f"{_ROOM}.figure_06_cloud_optics:figure_6",
        5.0,
    ),
    Item(
        "figure-9",
        "Static scenes of Table I over view angles",
        f"{_ROOM}.figure_09_static_scenes:figure_9",
        50.0,
    ),
    Item("figure-10", "Four cloud types over the sea", f"{_ROOM}.figure_10_cloud_types:figure_10", 8.0),
    Item("figure-11", "One sky in pixels of 5, 20 and 50 m", f"{_ROOM}.figure_11_resolutions:figure_11", 8.0),
    Item(
        "figure-12",
        "Stratus in three bands over eight seconds",
        f"{_ROOM}.figure_12_push_broom:figure_12",
        10.0,
    ),
    Item("figure-13", "Coverage from 10 to 50 %", f"{_ROOM}.figure_13_coverage:figure_13", 8.0),
    Item("figure-14", "Real and simulated cloud image", f"{_ROOM}.figure_14_cloud_images:figure_14", 4.0),
    Item(
        "figure-15",
        "Transmittance to the detector over wavelength and angle",
        f"{_ROOM}.figure_15_transmittance:figure_15",
        8.0,
    ),
    Item(
        "figure-16",
        "Mean transmittance to the detector over angle",
        f"{_ROOM}.figure_15_transmittance:figure_16",
        8.0,
    ),
    Item(
        "figure-17",
        "Degraded image of cirrus in 2.7-3.0 um",
        f"{_ROOM}.figure_17_degraded_cirrus:figure_17",
        5.0,
    ),
)
