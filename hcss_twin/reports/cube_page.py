"""Report page of a cube: frames, curves, scene geometry, certificate, approximations, provenance."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.cube.frame_selection import FrameSelection
from hcss_twin.cube.reader import open_cube
from hcss_twin.cube.sensor_cube import SENSOR_ATTRIBUTE
from hcss_twin.cube.zarr_writer import cube_bytes
from hcss_twin.reports.cube_frames import WINDOW_PIXELS, Reader, Series, read_all
from hcss_twin.reports.cube_viewer import viewer, viewer_script
from hcss_twin.reports.figures import Figures
from hcss_twin.reports.page import Markup, Page
from hcss_twin.reports.provenance import Provenance
from hcss_twin.reports.scene_section import scene_blocks
from hcss_twin.reports.tables import Table, bound_text

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def cube_page(path: Path) -> Page:
    """Return the page of a cube, clean or measured, NetCDF or Zarr.

    Raises
    ------
    CubeError
        If it is not a complete cube.
    """
    with open_cube(path) as opened:
        dataset = FrameSelection.as_seen(opened)
        attributes = {str(name): value for name, value in dataset.attrs.items()}
        sections, scripts = _frames(dataset)
        if SENSOR_ATTRIBUTE in attributes:
            sections.append(Page.Section("Sensor", [_sensor(attributes)]))
        file = f"{path.name}, {cube_bytes(path) / 1e6:.1f} MB"
        keys = {"id": "identifier", "date_created": "written", "hcss_seed": "seed"}
        about = Provenance.blocks(
            attributes, file, keys, shown=Provenance.names_in((), "hcss_", "geospatial_", "time_coverage_")
        )
        sections += [
            Page.Section("Scene", list(scene_blocks(dataset))),
            Page.Section("Certificate", list(_certificate(attributes))),
            Page.Section("Plan and approximations", list(_plan(attributes))),
            Page.Section("Provenance", [*about, *Provenance.origin(attributes)]),
        ]
        return Page(str(attributes.get("title", path.name)), _subtitle(dataset, path), sections, scripts)


def _frames(dataset: xr.Dataset) -> tuple[list[Page.Section], list[str]]:
    shown = Reader.quantities(dataset)
    if not shown or not all(dataset.sizes.values()):
        return [Page.Section("Frames", [Markup.note("The cube holds no variable with frames.")])], []
    reader = Reader.of(dataset)
    series, first, others = read_all(reader, shown)
    window = (min(WINDOW_PIXELS, dataset.sizes["y"]), min(WINDOW_PIXELS, dataset.sizes["x"]))
    return [
        Page.Section("Frames", [viewer(reader, series, first, others)]),
        Page.Section("Numbers and curves", [_curves(dataset, series, window), _numbers(series)]),
    ], [viewer_script(dataset, series)]


def _subtitle(dataset: xr.Dataset, path: Path) -> str:
    sizes = dataset.sizes
    parts = []
    if "time" in sizes:
        parts.append(Table.frames_text(sizes["time"]))
    if {"y", "x"} <= set(sizes):
        parts.append(f"{sizes['y']} x {sizes['x']} pixels")
    if "band" in sizes:
        parts.append("bands " + ", ".join(str(band) for band in dataset["band"].to_numpy()))
    if "time" in dataset.coords:
        parts.append(f"from {np.datetime_as_string(dataset['time'].to_numpy()[0], unit='s')}Z")
    kind = "Measured cube" if SENSOR_ATTRIBUTE in dataset.attrs else "Cube"
    return f"{kind} {path.name}: {', '.join(parts)}"


def _numbers(series: Sequence[Series]) -> Table:
    """Return the mean, minimum and maximum of every quantity and band over the shown frames."""
    rows = []
    for one in series:
        known = [numbers for numbers in one.numbers if not np.isnan(numbers.mean)]
        values = ["none"] * 3
        if known:
            mean = np.mean([numbers.mean for numbers in known])
            ends = min(numbers.lowest for numbers in known), max(numbers.highest for numbers in known)
            values = [f"{value:.5g}" for value in (mean, *ends)]
        rows.append([one.quantity.label, one.part, str(len(one.frames)), *values, one.quantity.units])
    header = ["quantity", "band or layer", "frames", "mean", "lowest", "highest", "unit"]
    return Table(header, rows, "Over the frames shown above; the mean is that of the frames' means.", text_columns=2)


def _curves(dataset: xr.Dataset, series: Sequence[Series], window: tuple[int, int]) -> Markup:
    """Return the figures of every quantity that has a histogram.

    Parameters
    ----------
    dataset : Dataset
        The cube, which supplies the times.
    series : sequence of Series
    window : (int, int)
        Rows and columns of the central part of the frame used for the spectrum.
    """
    # one row per kind of curve: radiance and temperature are side by side
    kinds: list[list[Markup]] = [[], [], []]
    for name in Reader.CURVES:
        of_quantity = [one for one in series if one.quantity.name == name]
        group = [one for one in of_quantity if one.histogram is not None]
        if not group:
            continue
        shown, label, frames = (
            group[: Figures.DRAWN_BANDS],
            of_quantity[0].quantity.label,
            Table.frames_text(len(of_quantity[0].frames)),
        )
        more = f" The first {Figures.DRAWN_BANDS} of {len(group)} bands." if len(group) > Figures.DRAWN_BANDS else ""
        if len(group) < len(of_quantity):
            alike = ", ".join(one.part for one in of_quantity if one.histogram is None)
            more += f" Not shown: {alike}, where all pixels have the same value."
        kinds[0].append(
            Markup.drawing(
                _histograms(shown), f"histograms of {label}", f"Histograms of {label}, pixels of {frames}.{more}"
            )
        )
        if any(one.spectrum is not None for one in shown):
            caption = (
                f"Power spectra of {label}, averaged over directions and {frames}: the central {window[0]} x "
                f"{window[1]} pixels, after subtracting a plane and tapering.{more}"
            )
            kinds[1].append(Markup.drawing(_spectra(shown), f"power spectra of {label}", caption))
        if len(of_quantity[0].frames) > 1:
            caption = f"Mean of {label} over the frame; the band spans the lowest to the highest pixel.{more}"
            kinds[2].append(Markup.drawing(_over_time(dataset, shown), f"{label} over time", caption))
    return Markup.beside(*(figure for kind in kinds for figure in kind))


def _histograms(group: Sequence[Series]) -> Figure:
    figure, axes = Figures.panels(len(group))
    for axis, one in zip(axes, group, strict=True):
        assert one.histogram is not None
        counts, edges = one.histogram
        axis.stairs(100.0 * counts / counts.sum(), edges, fill=True, color=Figures.INK, alpha=0.75)
        axis.set_yscale("log")
        axis.minorticks_off()
        axis.set_title(one.part, fontsize=Figures.LETTERS, loc="left")
        axis.set_ylabel("% of pixels", fontsize=Figures.LETTERS)
    axes[-1].set_xlabel(Figures.axis_label(group[0].quantity.label, group[0].quantity.units), fontsize=Figures.LETTERS)
    return figure


def _spectra(group: Sequence[Series]) -> Figure:
    figure, (axis,) = Figures.panels(1, 3.0)
    for index, one in enumerate(group):
        if one.spectrum is not None:
            style = ("-", "--", "-.", ":")[index % 4]
            axis.loglog(one.spectrum.cycles_per_km, one.spectrum.power, style, label=one.part, lw=1.3)
    axis.minorticks_off()
    axis.set_xlabel("wavenumber (cycles per km)", fontsize=Figures.LETTERS)
    units = group[0].quantity.units
    axis.set_ylabel(f"power (({units})² km²)" if units else "power (km²)", fontsize=Figures.LETTERS)
    axis.legend(fontsize=Figures.LETTERS - 1, frameon=False)
    return figure


def _over_time(dataset: xr.Dataset, group: Sequence[Series]) -> Figure:
    figure, axes = Figures.panels(len(group))
    times = dataset["time"].to_numpy()
    for axis, one in zip(axes, group, strict=True):
        seconds = (times[list(one.frames)] - times[0]) / np.timedelta64(1, "ns") * 1e-9
        lowest, highest, mean = (
            [getattr(numbers, name) for numbers in one.numbers] for name in ("lowest", "highest", "mean")
        )
        axis.fill_between(seconds, lowest, highest, color=Figures.INK, alpha=0.15, lw=0)
        axis.plot(seconds, mean, "o-", color=Figures.INK, ms=3, lw=1.2)
        axis.set_title(one.part, fontsize=Figures.LETTERS, loc="left")
        axis.set_ylabel(one.quantity.units, fontsize=Figures.LETTERS)
    axes[-1].set_xlabel("time (s)", fontsize=Figures.LETTERS)
    return figure


def _sensor(attributes: Mapping[str, Any]) -> Markup.Block:
    """Return the sensor description of a measured cube; missing properties are omitted."""
    about = Provenance.value(attributes, SENSOR_ATTRIBUTE, {})
    pairs: list[tuple[str, str]] = []
    for key, value in about.items():
        if isinstance(value, dict):
            items = (f"{_spaced(name)}: {_value(item)}" for name, item in value.items() if item is not None)
            pairs.append((_spaced(key), Markup.bullets(items)))
        elif value not in (None, "", []):
            pairs.append((_spaced(key), _value(value)))
    if "clean_cube" in attributes:
        pairs.append(("clean cube", str(attributes["clean_cube"])))
    return Markup.facts(pairs)


def _spaced(name: str) -> str:
    return name.replace("_", " ")


def _value(value: object) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{_spaced(str(key))} {_value(item)}" for key, item in value.items())
    if isinstance(value, list):
        return "; ".join(_value(item) for item in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _certificate(attributes: Mapping[str, Any]) -> Iterator[Markup.Block]:
    """Yield the requested, estimated and achieved accuracy."""
    requested = attributes.get("hcss_accuracy_requested")
    words = attributes.get("hcss_certificate")
    none = Markup.badge("no certificate", "plain" if requested is None else "fair")
    yield Markup.element("p", Provenance.badge(words) or none)
    if words is None:
        unchecked = "No pixel was checked: the scenario's output.certificate is 0."
        yield Markup.note("The cube holds no radiance that could be checked." if requested is None else unchecked)
    if SENSOR_ATTRIBUTE in attributes:
        yield Markup.note("The certificate is that of the clean cube, whose radiance the sensor measured.")
    if requested is not None:
        yield achieved_table(attributes)
    strata = Provenance.value(attributes, "hcss_certificate_strata", [])
    if strata:
        bands = list(dict.fromkeys(band for stratum in strata for band in stratum.get("error", {})))
        rows = [
            [
                *(str(stratum[key]) for key in ("name", "pixels", "checked", "exceeding")),
                str(sum(stratum.get("left_out", {}).values())),
                *(_error(stratum.get("error", {}).get(band)) for band in bands),
            ]
            for stratum in strata
        ]
        header = ["kind of pixel", "there are", "checked", "exceed", "excluded", *(f"error {band}" for band in bands)]
        yield Table(header, rows, "Pixels of the checked frames by kind.")
    terms = Provenance.value(attributes, "hcss_certificate_terms", {})
    if terms:
        rows = [[_spaced(name), _error(error)] for name, error in terms.items()]
        yield Table(["term", "largest error"], rows, "Terms of the radiance, relative to the total of the band.")
    budget = Provenance.value(attributes, "hcss_error_budget", {})
    if budget:
        rows = [
            [of, band, *_total(cell), _contributions(cell)]
            for of, bands in budget.items()
            for band, cell in bands.items()
        ]
        caption = (
            "Total error, models included: root of the sum of squares; at least that, where a part is unknown; "
            "(notes): not recomputed."
        )
        yield Table(["class", "band", "%", "kelvin", "contributions in %"], rows, caption, text_columns=2)
    beyond = Provenance.value(attributes, "hcss_beyond_accuracy", [])
    if beyond:
        yield Markup.note("Not within the requested accuracy because of omitted effects:")
        yield Markup.bullets(str(effect) for effect in beyond)
    left_out = Provenance.value(attributes, "hcss_left_out", [])
    if left_out:
        yield Markup.note("Left out, by choice or for the time it takes:")
        yield Markup.bullets(str(effect) for effect in left_out)
    if words is not None:
        yield Markup.folded("The certificate in words", Markup.bullets(str(words).split("; ")))


def _total(cell: Mapping[str, Any]) -> tuple[str, str]:
    """Total error of a class and band in percent and kelvin."""
    name = "at_least" if "at_least" in cell else "total"
    least = "at least " if cell["unknown"] else ""
    return f"{least}{100.0 * cell[name]:.2g}", f"{least}{cell[f'{name}_K']:.2g}"


def _contributions(cell: Mapping[str, Any]) -> str:
    """Contributions to one class and band, the largest first, and the names of the unknown ones."""
    known = [contribution for contribution in cell["contributions"] if contribution["relative"] is not None]
    parts = [
        f"{contribution['name']} {100.0 * contribution['relative']:.2g}"
        f"{'' if contribution['recomputed'] else ' (notes)'}"
        for contribution in sorted(known, key=lambda contribution: -contribution["relative"])
    ]
    return ", ".join([*parts, *(f"{name} unknown" for name in cell["unknown"])])


def _bound_text(omission: Mapping[str, Any], key: str) -> str:
    value = omission.get(key)
    if key == "bound":
        return bound_text(value)
    return "" if value is None else f"{bound_text(value)} ({omission.get('sense', '')})"


def achieved_table(attributes: Mapping[str, Any]) -> Table:
    """Return the requested, estimated and achieved accuracy by band."""
    requested, estimated = (
        _error(attributes.get(f"hcss_{key}")) for key in ("accuracy_requested", "table_error_estimated")
    )
    errors = Provenance.value(attributes, "hcss_accuracy_achieved", {})
    rows = [[band, requested, estimated, _error(error)] for band, error in errors.items()]
    rows = rows or [["all", requested, estimated, "not checked"]]
    header = ["band", "requested", "estimated", "achieved"]
    if "hcss_accuracy_requested_kelvin" in attributes:
        kelvin = Provenance.value(attributes, "hcss_accuracy_achieved_kelvin", {})
        asked_kelvin = _error(attributes["hcss_accuracy_requested_kelvin"])
        header += ["requested, K", "achieved, K"]
        rows = [[*row, asked_kelvin, _error(kelvin.get(row[0]))] for row in rows]
    caption = "Largest error relative to the radiance of the band; achieved: of the checked pixels."
    return Table(header, rows, caption)


def _error(value: Any) -> str:
    return Table.number(None if value is None else float(value), 3, "none")


def _plan(attributes: Mapping[str, Any]) -> Iterator[Markup.Block]:
    """Yield the defaults used, the approximations with their bounds, and the error of each."""
    filled = Provenance.value(attributes, "hcss_filled_in", [])
    if filled:
        rows = [[str(entry[key]) for key in ("field", "value", "why")] for entry in filled]
        yield Table(["filled in", "value", "why"], rows, "Values that the scenario does not give.", text_columns=3)
    skipped = Provenance.value(attributes, "hcss_skipped", [])
    if skipped:
        # unknown bounds come between known and zero bounds
        ranked = sorted(skipped, key=lambda omission: -(1e-300 if omission.get("bound") is None else omission["bound"]))
        rows = [
            [
                str(omission["what"]),
                *(_bound_text(omission, key) for key in ("bound", "estimate")),
                str(omission["why"]),
            ]
            for omission in ranked
        ]
        caption = (
            "Approximations and omitted physics, with the largest share of the radiance of any pixel that each can "
            "change. Unknown: equal in distribution, not pixel by pixel, or as the reason says."
        )
        yield Table(["what", "at most", "typical", "why"], rows, caption, text_columns=4)
    notes = Provenance.value(attributes, "hcss_notes", [])
    if notes:
        yield Markup.element("h3", "Notes of the providers")
        yield Markup.bullets(str(text) for text in notes)
    if not (filled or skipped or notes):
        yield Markup.paragraph("The cube contains no plan.")
    errors = [(name, error) for name, error in Provenance.value(attributes, "hcss_table_errors", {}).items() if error]
    if errors:
        rows = [
            [_spaced(name), _error(error)] for name, error in sorted(errors, key=lambda named_error: -named_error[1])
        ]
        caption = "Relative error measured while compiling the radiance tables; the other approximations have none."
        yield Table(["approximation", "measured error"], rows, caption)
    if "hcss_wavenumbers_used" in attributes:
        used, known = attributes["hcss_wavenumbers_used"], attributes.get("hcss_wavenumbers_known")
        yield Markup.paragraph(f"{used} weighted wavenumbers represent {known}.")
