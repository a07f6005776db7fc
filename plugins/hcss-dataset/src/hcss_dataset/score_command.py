"""``hcss score``: detections in a data set."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hcss_twin.cli.options import Existing, Number, Output, Shared, Stop

if TYPE_CHECKING:
    from hcss_dataset.scoring import Detection, Scored

NAMES = ("log", "top-hat", "matched-filter")


@click.command("score")
@click.argument("paths", nargs=-1, required=True, type=Existing(), metavar="[DETECTIONS] DATASET")
@click.option("--baseline", type=click.Choice(NAMES), help="Detections of this detector, in place of DETECTIONS.")
@click.option("--split", type=click.Choice(("train", "val", "test")), help="Only frames of this split.")
@click.option("--band", help="Band of images and targets; default: the first.")
@click.option("--radius", default=3.0, show_default=True, type=Number(min=0.0), help="Of a match, pixels.")
@click.option("--least-snr", default=1.0, show_default=True, type=Number(min=0.0), help="Of targets that count.")
@click.option("-o", "--output", type=Output(dir_okay=False), help="CSV file for the detections of a baseline.")
@click.option("--curve", type=Output(dir_okay=False), help="CSV file for the curve over all thresholds.")
@click.option("--clutter", is_flag=True, help="Measure DATASET's backgrounds; the tail is that of --baseline.")
@click.option("--jitter", default=0.1, show_default=True, type=Number(min=0.0), help="With --clutter: rms pixels.")
@Shared.force
@Shared.json
@click.pass_context
def score_command(
    context: click.Context,
    paths: tuple[Path, ...],
    baseline: str | None,
    split: str | None,
    band: str | None,
    radius: float,
    least_snr: float,
    output: Path | None,
    curve: Path | None,
    clutter: bool,
    jitter: float,
    force: bool,
    as_json: bool,
) -> None:
    """Score DETECTIONS in DATASET: detection rate against false alarms, by SCR.

    DETECTIONS is a CSV file (key, row, column, score), results of COCO (.json), or a folder of masks KEY.png.

    With --clutter, spectra, jitter clutter and detection rates down to 1e-8 false alarms a pixel of DATASET.
    """
    if clutter:
        if len(paths) != 1 or output is not None or curve is not None:
            raise click.UsageError("--clutter with DETECTIONS, --output or --curve; allowed: DATASET alone")
        baseline = baseline or "matched-filter"
    elif context.get_parameter_source("jitter") is not click.core.ParameterSource.DEFAULT:
        raise click.UsageError("--jitter without --clutter; allowed: with it")
    if len(paths) != (1 if baseline else 2):
        wanted = "DATASET alone" if baseline else "DETECTIONS and DATASET, or DATASET with --baseline"
        raise click.UsageError(f"{len(paths)} paths; allowed: {wanted}")
    if output is not None and baseline is None:
        raise click.UsageError("--output without --baseline; allowed: with it")
    Output.require_writable([output, curve], force, form="")
    from hcss_dataset.reader import Frames
    from hcss_dataset.scoring import read_detections, score

    frames = Frames(paths[-1], split)
    if not len(frames):
        raise click.UsageError(f"{paths[-1]} has no frame in split '{split}'; allowed: another split")
    number = _band(frames[0].labels["bands"], band)
    if clutter and baseline is not None:
        from hcss_dataset.clutter import clutter_text, measure_clutter

        shown = context.ensure_object(Stop).progress(frames, len(frames), label="frames")
        measured = measure_clutter(shown, baseline, radius, least_snr, number)
        if as_json:
            Shared.write_json(_plain(measured.as_dict(jitter)))
        else:
            click.echo(clutter_text(measured, jitter))
        return
    if baseline is None:
        detections: Mapping[str, Sequence[Detection]] = read_detections(paths[0])
        keys = {frame.labels["key"] for frame in frames}
        if split is not None:  # detections of all splits may be in one file
            detections = {key: given for key, given in detections.items() if key in keys}
    else:
        shown = context.ensure_object(Stop).progress(frames, len(frames), label="frames")
        detections = _of_baseline(baseline, shown, number)
    scored = context.ensure_object(Stop).progress(frames, len(frames), label="scoring")
    result = score((frame.labels for frame in scored), detections, radius, least_snr, number)
    if output is not None:
        rows = ((key, each.row, each.column, each.score) for key, of in detections.items() for each in of)
        _write(output, ("key", "row", "column", "score"), rows)
    if curve is not None:
        columns = result.curve()
        _write(curve, tuple(columns), zip(*(values.tolist() for values in columns.values()), strict=True))
    if as_json:
        Shared.write_json(_plain(_summary(result)))
        return
    click.echo(_text(result))


def _band(names: Sequence[str], wanted: str | None) -> int:
    if wanted is not None and wanted not in names:
        raise click.BadParameter(f"'{wanted}'; allowed: {', '.join(names)}", param_hint="--band")
    return 0 if wanted is None else names.index(wanted)


def _of_baseline(name: str, frames: Iterable[Any], band: int) -> dict[str, list[Detection]]:
    from hcss_dataset.baselines import detect

    return {frame.labels["key"]: detect(name, frame.image[band].astype(float)) for frame in frames}


def _summary(result: Scored) -> dict[str, Any]:
    from hcss_dataset.scoring import RATES

    points = []
    for rate in RATES:
        threshold = result.threshold_at(rate)
        point = {"at_most": rate, **result.at_threshold(threshold), "by_scr": result.by_scr(threshold)}
        points.append(point)
    return {
        "frames": result.frames,
        "pixels": result.image_pixels,
        "targets": int(result.scr.size),
        "targets_that_do_not_count": result.ignored,
        "radius": result.radius,
        "most_detections_in_a_frame": result.most,
        "all": result.at_threshold(-math.inf),
        "points": points,
    }


def _text(result: Scored) -> str:
    summary = _summary(result)
    whole = summary["all"]
    lines = [
        f"{summary['frames']} frames, {summary['targets']} targets that count, {summary['targets_that_do_not_count']} "
        f"hidden or below --least-snr; matches within {summary['radius']:g} pixels",
        f"all detections: {whole['found']} targets found, {whole['false_alarms']} false alarms "
        f"({whole['false_pixels']} pixels, {whole['false_pixel_share']:.3g} of all)",
        *_capped(result),
        "false alarms a pixel, at most  threshold  found  rate   by SCR",
    ]
    for point in summary["points"]:
        classes = ", ".join(
            f"{each['scr_from']:g}-{each['scr_to']:g}: {each['found']}/{each['targets']}"
            for each in point["by_scr"]
            if each["targets"]
        )
        lines.append(
            f"{point['at_most']:<29g}  {point['threshold']:<9.4g}  {point['found']:<5d}  "
            f"{point['detection_rate']:.3f}  {classes}"
        )
    return "\n".join(lines)


def _capped(result: Scored) -> list[str]:
    """Return a line on detectors that keep no more than some detections of a frame, as those for COCO do."""
    from hcss_dataset.baselines import MAX_PER_FRAME

    if result.most != MAX_PER_FRAME:
        return []
    return [
        f"no frame has more than {result.most} detections, where COCO's evaluation ends, too (maxDets): rates beyond "
        f"{result.at_threshold(-math.inf)['false_alarms_per_pixel']:.3g} false alarms a pixel are not known"
    ]


def _plain(value: Any) -> Any:
    """Return values for JSON, which has no infinite numbers."""
    if isinstance(value, dict):
        return {name: _plain(content) for name, content in value.items()}
    if isinstance(value, list):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _write(path: Path, header: Sequence[str], rows: Iterable[Iterable[Any]]) -> None:
    from hcss_dataset.errors import DatasetError
    from hcss_twin.core.files import Writing

    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    with Writing(path, DatasetError) as draft:
        draft.write_text(text.getvalue(), encoding="utf-8")
