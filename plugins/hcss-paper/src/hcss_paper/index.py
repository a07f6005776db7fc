"""All tables and figures that can be recomputed, and their names."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from hcss_twin.providers import HcssError, choose_from


@dataclass(frozen=True)
class Item:
    """A table or figure of the paper that can be computed.

    Attributes
    ----------
    name : str
        ``table-2`` or ``figure-12``.
    title : str
        Content of the table or figure.
    target : str
        ``"package.module:function"`` that takes the seed of random fields and returns a
        :class:`~hcss_paper.reproduction.Reproduction`; imported when the item is computed.
    numbers : int
        How many printed numbers the item must compare with computed ones; an item that compares another number of them
        fails, so that no row loses its printed number unnoticed.
    """

    name: str
    title: str
    target: str
    numbers: int = 0


def _item(name: str, title: str, target: str, numbers: int = 0) -> Item:
    return Item(name, title, f"hcss_paper.{target}", numbers)


TABLES: tuple[Item, ...] = (
    _item("headline", "Errors claimed in the abstract", "claims:headline", 5),
    _item("table-1", "Static scenes: bands and coverages", "tables_1_and_3:table_1", 18),
    _item("table-2", "Radiance of static scenes against view angle", "tables_2_and_4:table_2", 32),
    _item("table-2-modtran", "MODTRAN radiance of Table II", "tables_2_and_4:table_2_modtran", 32),
    _item("table-3", "Shape parameters and heights of cloud types", "tables_1_and_3:table_3", 32),
    _item("table-4", "Radiance of dynamic scenes against view angle, 3-5 and 8-14 um", "tables_2_and_4:table_4", 16),
    _item("table-4-modtran", "MODTRAN radiance of Table IV, 3-5 and 8-14 um", "tables_2_and_4:table_4_modtran", 16),
    _item(
        "table-4-swir",
        "Radiance of dynamic scenes and of MODTRAN against view angle, 2.7-3.0 um",
        "tables_2_and_4:table_4_short_wave",
        24,
    ),
    _item("table-5", "Radiance at twenty places", "tables_5_to_7:table_5", 20),
    _item("table-6", "Radiance over the year", "tables_5_to_7:table_6", 12),
    _item("table-7", "Radiance against cloud coverage", "tables_5_to_7:table_7", 5),
    _item(
        "table-8", "Measures of a simulated and a real cloud image: Den, DP, FD and RMSE", "tables_8_and_9:table_8", 8
    ),
    _item("table-8-ev", "Measures of the images of Table VIII: EV", "tables_8_and_9:table_8_entropy", 1),
    _item("table-9", "Measures of cloud images with three coverages: DP, FD and RMSE", "tables_8_and_9:table_9", 9),
    _item("table-9-ev", "Measures of the images of Table IX: EV and Den", "tables_8_and_9:table_9_entropy", 6),
    _item("table-10", "Features of the method", "claims:table_10"),
    _item("sun-angles", "Sun angles of Tables V and VI and of the baseline scene", "tables_5_to_7:sun_angles", 66),
    _item("sensitivity", "Sensitivity to coverage, month and place against MODTRAN", "tables_5_to_7:sensitivity", 7),
    _item("resolutions", "Resolutions of 20 to 100 m and coverages of 10 to 50 %", "claims:resolutions", 6),
)

FIGURES: tuple[Item, ...] = (
    _item("figure-3", "Pierson-Moskowitz spectrum at several wind speeds", "figure_03_sea_spectrum:figure_3", 1),
    _item("figure-4", "Fractal fields with different gamma, H, L and kmax", "figure_04_fractal_fields:figure_4"),
    _item("figure-5", "A cloud in three dimensions", "figure_05_cloud_volume:figure_5", 3),
    _item("figure-6", "Optical properties of cumulus, stratus and cirrus", "figure_06_cloud_optics:figure_6"),
    _item("figure-9", "Static scenes of Table I over view angles", "figure_09_static_scenes:figure_9", 32),
    _item("figure-10", "Four cloud types over the sea", "figure_10_cloud_types:figure_10", 10),
    _item("figure-11", "One cloud field with pixels of 5, 20 and 50 m", "figure_11_resolutions:figure_11"),
    _item("figure-12", "Stratus in three bands for eight seconds", "figure_12_push_broom:figure_12", 6),
    _item("figure-13", "Coverage from 10 to 50 %", "figure_13_coverage:figure_13", 10),
    _item("figure-14", "Real and simulated cloud image", "figure_14_cloud_images:figure_14", 4),
    _item(
        "figure-15", "Transmittance to the detector against wavelength and angle", "figure_15_transmittance:figure_15"
    ),
    _item("figure-16", "Mean transmittance to the detector against angle", "figure_15_transmittance:figure_16"),
    _item("figure-17", "Degraded image of cirrus in 2.7-3.0 um", "figure_17_degraded_cirrus:figure_17", 3),
)

ITEMS: tuple[Item, ...] = TABLES + FIGURES

_ONES = ("", "I", "II", "III", "IV", "V", "VI", "VII", "VIII", "IX")
_ROMAN = ("0", *(f"{tens}{ones}" for tens in ("", "X", "XX", "XXX") for ones in _ONES if tens or ones))


def chosen(names: Sequence[str]) -> tuple[Item, ...]:
    """Return the named items in the order of :data:`ITEMS`; all items if no name is given.

    Names may be those of the paper: ``"Table II"``, ``"table 2"``, ``"II"``, ``"Fig. 12"``.

    Raises
    ------
    HcssError
        If no item has a name; the message gives the closest one.
    """
    known = {item.name: item for item in ITEMS}
    wanted = {name: _item_name(name) for name in names}
    for name, meant in wanted.items():
        if meant not in known:
            raise HcssError(f"no item '{name}'; {choose_from(meant, known)}")
    return tuple(item for item in ITEMS if not names or item.name in wanted.values())


def _item_name(text: str) -> str:
    """Return ``table-2-modtran`` for ``"Table II, MODTRAN"``: the name of an item if it is written as in the paper."""
    numbers = {numeral.lower(): str(number) for number, numeral in enumerate(_ROMAN[1:], 1)}
    words = [word for word in re.split(r"[^0-9a-z]+", text.lower()) if word]
    kinds = {"fig": "figure", "tab": "table"}
    words = [kinds.get(word, word) for word in words]
    if words and (words[0] in numbers or words[0].isdigit()):  # only tables have Roman numbers
        words.insert(0, "table")
    return "-".join(numbers.get(word, word) if number == 1 else word for number, word in enumerate(words))


def heading(name: str) -> str:
    """Return the name of an item in the form used in the paper: ``Table IV, modtran``, ``Figure 12``."""
    kind, *rest = name.split("-")
    if not rest:
        return kind.capitalize()
    number = _ROMAN[int(rest[0])] if kind == "table" and rest[0].isdigit() else rest[0]
    return ", ".join([f"{kind.capitalize()} {number}", *(word.upper() for word in rest[1:])])
