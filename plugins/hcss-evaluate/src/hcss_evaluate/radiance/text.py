"""The blind test of radiances as text for a terminal."""

from __future__ import annotations

from pathlib import Path

from hcss_evaluate.radiance.blind import BlindTest
from hcss_twin import __version__
from hcss_twin.reports.page import Markup, Page
from hcss_twin.reports.tables import Table

_MEANING = (
    "Clear sea: sea temperature, wind and air of the climatology. Opaque cloud: it has the temperature measured near "
    "10.8 um, so that this channel tests the air above it, and the others how clouds differ between channels."
)


def blind_table(test: BlindTest) -> Table:
    """Return the differences by kind and channel."""
    rows = [
        [
            difference.kind,
            difference.channel,
            _limits(test, difference.channel),
            str(difference.spots),
            f"{difference.measured_K:.2f}",
            f"{difference.mean_K:+.2f}",
            "-" if difference.spots < 2 else f"{difference.sd_K:.2f}",
        ]
        for difference in test.differences
    ]
    return Table(
        ["spots of", "channel", "um", "number", "measured, K", "simulated less measured, K", "sd, K"],
        rows,
        "Brightness temperature where only place, time and view were given",
        text_columns=3,
    )


def _limits(test: BlindTest, channel: str) -> str:
    """Return the limits of a channel; of one with a response, those of half power and the file."""
    low, high = test.limits_um[channel]
    response = test.responses.get(channel)
    if response is None:
        return f"{low:g}-{high:g}"
    column = f":{response['column']}" if "column" in response else ""
    return f"{low:.4g}-{high:.4g} (half power), {Path(response['response']).name}{column}"


def blind_text(test: BlindTest) -> str:
    """Return the table, and what it means."""
    return "\n".join((*blind_table(test).lines(), _MEANING, *(f"note: {text}" for text in test.notes)))


def blind_page(test: BlindTest) -> Page:
    """Return the report page: the differences, and every spot."""
    rows = [
        [
            spot.kind, f"{spot.time:%Y-%m-%d %H:%M}", f"{spot.latitude:.2f}", f"{spot.longitude:.2f}",
            f"{spot.view_zenith:.1f}", str(spot.pixels),
            *(f"{kelvin[name]:.2f} / {spot.kelvin[name]:.2f}" for name in test.limits_um),
        ]
        for spot, kelvin in zip(test.spots, test.simulated_K, strict=True)
    ]  # fmt: skip
    header = ["spot", "time, UTC", "latitude", "longitude", "view zenith", "pixels", *test.limits_um]
    sections = [
        Page.Section(
            "Differences", [blind_table(test), Markup.paragraph(_MEANING), *(Markup.note(text) for text in test.notes)]
        ),
        Page.Section("Spots", [Table(header, rows, "Simulated / measured brightness temperature, K", text_columns=2)]),
    ]
    return Page("Simulated and measured radiance", f"{len(test.spots)} spots | hcss {__version__}", sections)
