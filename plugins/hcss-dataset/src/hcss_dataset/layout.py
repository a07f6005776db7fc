"""Files over all shards of a data set: targets, COCO, MOT, Croissant and the card."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from hcss_dataset.distribution import SPLITS
from hcss_dataset.errors import DatasetError
from hcss_dataset.images import SUFFIXES
from hcss_dataset.shards import SHARDS, Layout
from hcss_dataset.viewer import FAINT_SNR, INDEX, write_viewer
from hcss_twin.core.files import Writing

TARGETS, ANNOTATIONS, MOT, CROISSANT, CARD = "targets.jsonl", "annotations", "mot", "croissant.json", "README.md"

_OF_FRAME = ("key", "draw", "frame", "time_s", "split", "sky", "state", "file")
_NUMBERS = (
    ("altitude_m", "Altitude above the sea, m."),
    ("position_m", "East and north of the image centre at the start, m."),
    ("velocity_m_s", "Toward east, north and up, m/s."),
    ("pixels_per_s", "Rows and columns per second against the image."),
    ("centroid", "Row and column of the light; pixel n extends from n to n + 1."),
    ("place", "Row and column of the middle of the target."),
    ("intensity_W_sr", "Of a plume toward the sensor, by band."),
    ("temperature_K", "Of a body."),
    ("area_m2", "Of a body across the line of sight."),
    ("transmittance", "Of air and clouds before the target, by band."),
    ("visible", "Share that clouds and higher targets leave, by band."),
    ("flux", "Sum over the pixels of what the target adds, W m-2 sr-1, by band."),
    ("peak", "What it adds to its highest pixel, W m-2 sr-1, by band."),
    ("clutter", "Standard deviation of the clean image around it, W m-2 sr-1, by band."),
    ("snr", "Peak over rms noise of the frame, by band."),
    ("scr", "Peak over the standard deviation of clutter and noise together, by band."),
)


def finish(layout: Layout) -> int:
    """Write the files over all shards; return the number of refused draws.

    Raises
    ------
    DatasetError
        If a file cannot be written.
    """
    _write_lines(layout.folder / TARGETS, (json.dumps(each) for each in _targets(layout.records())))
    for split in SPLITS:
        _coco(layout, split)
    if layout.per_draw > 1:
        _mot(layout)
    heads = layout.heads()
    summary = _summary(layout)
    _write(layout.folder / CROISSANT, json.dumps(_croissant(layout), indent=1) + "\n")
    _write(layout.folder / CARD, _card(layout, summary, heads))
    write_viewer(layout, summary)
    return sum(head["refused"] for head in heads)


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with Writing(path, DatasetError) as draft:
        draft.write_text(text, encoding="utf-8")


def _write_lines(path: Path, lines: Iterable[str]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with Writing(path, DatasetError) as draft, draft.open("w", encoding="utf-8") as file:
        file.writelines(f"{line}\n" for line in lines)


def _targets(records: Iterable[Mapping[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield a line for each target of each frame, without its mask."""
    for record in records:
        of_frame = {name: record[name] for name in _OF_FRAME} | {"noise": record["noise"]}
        for target in record["targets"]:
            yield of_frame | {name: value for name, value in target.items() if name != "mask"}


def file_name(record: Mapping[str, Any]) -> str:
    """Return the name of the image of the first band of a frame, as extracted from its shard."""
    return f"{record['key']}.{next(iter(record['images']))}"


def _coco(layout: Layout, split: str) -> None:
    """Write the annotations of a split; masks are run lengths, which every reader of COCO takes."""
    images, annotations = list[dict[str, Any]](), list[dict[str, Any]]()
    for record in layout.records():
        if record["split"] != split:
            continue
        number = record["number"]
        images.append(
            {
                "id": number,
                "file_name": file_name(record),
                "width": record["columns"],
                "height": record["rows"],
                "shard": record["file"],
                "sequence": record["draw"],
                "frame": record["frame"],
            }
        )
        for target in record["targets"]:
            if target["mask"] is None:
                continue
            annotations.append(
                {
                    "id": len(annotations) + 1,
                    "image_id": number,
                    "category_id": 1,
                    "bbox": target["box"],
                    "area": sum(target["mask"]["counts"][1::2]),
                    "segmentation": target["mask"],
                    "iscrowd": 0,
                    "track_id": target["track"],
                    "centroid": target["centroid"],
                    "snr": target["snr"][0],
                    "scr": target["scr"][0],
                    "visible": target["visible"][0],
                }
            )
    path = layout.folder / ANNOTATIONS / f"{split}.json"
    if not images:
        path.unlink(missing_ok=True)
        return
    licence = {"id": 1, "name": layout.distribution.licence, "url": ""}
    content = {
        "info": {"description": layout.distribution.title, "version": layout.distribution.digest[:12]},
        "licenses": [licence],
        "categories": [{"id": 1, "name": "target", "supercategory": "point"}],
        "images": images,
        "annotations": annotations,
    }
    _write(path, json.dumps(content) + "\n")


def _mot(layout: Layout) -> None:
    """Write the ground truth and the description of each sequence, numbered from 1 as MOT wants."""
    lines: dict[int, list[str]] = {}
    about: dict[int, Mapping[str, Any]] = {}
    for record in layout.records():
        draw = record["draw"]
        about.setdefault(draw, record)
        rows = lines.setdefault(draw, [])
        for target in record["targets"]:
            if target["box"] is None:
                continue
            x, y, width, height = target["box"]
            visible = target["visible"][0]
            rows.append(f"{record['frame'] + 1},{target['track']},{x + 1},{y + 1},{width},{height},1,1,{visible:g}\n")
    for draw, rows in lines.items():
        first = about[draw]
        folder = layout.folder / MOT / first["split"] / f"{draw:06d}"
        _write(folder / "gt" / "gt.txt", "".join(rows))
        _write(
            folder / "seqinfo.ini",
            f"[Sequence]\nname={draw:06d}\nimDir=img1\nframeRate={1.0 / first['interval_s']:g}\n"
            f"seqLength={layout.per_draw}\nimWidth={first['columns']}\nimHeight={first['rows']}\nimExt={SUFFIXES[layout.distribution.form]}\n",
        )


def _summary(layout: Layout) -> dict[str, Any]:
    """Return counts and extremes over all frames."""
    frames, targets, empty, faint = Counter[str](), 0, 0, 0
    skies: dict[str, set[int]] = {split: set() for split in SPLITS}
    error, first = 0.0, None
    for record in layout.records():
        first = first or record
        frames[record["split"]] += 1
        skies[record["split"]].add(record["sky"])
        targets += len(record["targets"])
        faint += sum(_is_faint(target) for target in record["targets"])
        empty += not record["targets"]
        error = max(error, record["table_error"])
    assert first is not None
    return {
        "frames": frames,
        "skies": {split: len(found) for split, found in skies.items()},
        "targets": targets,
        "empty": empty,
        "faint": faint,
        "table_error": error,
        "first": first,
    }


def _is_faint(target: Mapping[str, Any]) -> bool:
    """Whether noise drowns a target in every band; without noise it never does."""
    return all(snr is not None and snr < FAINT_SNR for snr in target["snr"])


def _croissant(layout: Layout) -> dict[str, Any]:
    """Return the description of the table of targets, as Croissant 1.0."""
    path = layout.folder / TARGETS
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    columns = [
        ("key", "sc:Text", "Name of the frame, and of its files in the shard."),
        ("draw", "sc:Integer", "Number of the sequence."),
        ("frame", "sc:Integer", "Number of the frame in the sequence, from 0."),
        ("time_s", "sc:Float", "Time after the start of the sequence, s."),
        ("split", "sc:Text", "train, val or test: all frames of a sky are in one."),
        ("sky", "sc:Integer", "Number of the sky."),
        ("file", "sc:Text", f"Shard in {SHARDS}/."),
        ("track", "sc:Integer", "Number of the target in the sequence."),
        ("kind", "sc:Text", "plume or body."),
        ("altitude_m", "sc:Float", dict(_NUMBERS)["altitude_m"]),
    ]
    fields = [
        {
            "@type": "cr:Field",
            "@id": f"targets/{name}",
            "name": name,
            "description": text,
            "dataType": kind,
            "source": {"fileObject": {"@id": TARGETS}, "extract": {"column": name}},
        }
        for name, kind, text in columns
    ]
    return {
        "@context": _CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": "".join(each if each.isalnum() else "-" for each in layout.distribution.title.lower()).strip("-"),
        "description": layout.distribution.title,
        "license": layout.distribution.licence,
        "version": "1.0.0",
        "url": "https://example.org/",
        "distribution": [
            {
                "@type": "cr:FileObject",
                "@id": TARGETS,
                "name": TARGETS,
                "description": "One line of JSON for each target of each frame.",
                "contentUrl": TARGETS,
                "encodingFormat": "application/jsonlines",
                "sha256": digest,
            }
        ],
        "recordSet": [
            {"@type": "cr:RecordSet", "@id": "targets", "name": "targets", "description": "Targets.", "field": fields}
        ],
    }


_CONTEXT = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "cr": "http://mlcommons.org/croissant/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "dct": "http://purl.org/dc/terms/",
    "equivalentProperty": "cr:equivalentProperty",
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "extract": "cr:extract",
    "field": "cr:field",
    "fileObject": "cr:fileObject",
    "fileProperty": "cr:fileProperty",
    "fileSet": "cr:fileSet",
    "format": "cr:format",
    "includes": "cr:includes",
    "isLiveDataset": "cr:isLiveDataset",
    "jsonPath": "cr:jsonPath",
    "key": "cr:key",
    "md5": "cr:md5",
    "parentField": "cr:parentField",
    "path": "cr:path",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "recordSet": "cr:recordSet",
    "references": "cr:references",
    "regex": "cr:regex",
    "repeated": "cr:repeated",
    "replace": "cr:replace",
    "samplingRate": "cr:samplingRate",
    "sc": "https://schema.org/",
    "separator": "cr:separator",
    "source": "cr:source",
    "subField": "cr:subField",
    "transform": "cr:transform",
}
"""Terms of Croissant 1.0, as its specification gives them."""


def _card(layout: Layout, summary: Mapping[str, Any], heads: list[dict[str, Any]]) -> str:
    """Return the card of the data set."""
    distribution, first = layout.distribution, summary["first"]
    size = sum(sum(head["bytes"].values()) for head in heads)
    frames = layout.draws * layout.per_draw
    refused = sum(head["refused"] for head in heads)
    scale = "\n".join(
        f"| {band} | {step:.6g} | {offset:.6g} | {first['largest_number']} |"
        for band, step, offset in zip(
            first["bands"], first["radiance_per_number"], first["radiance_at_number_0"], strict=True
        )
    )
    splits = "\n".join(
        f"| {split} | {summary['skies'][split]} | {summary['frames'][split]} |"
        for split in SPLITS
        if summary["frames"][split]
    )
    fields = "\n".join(f"| `{name}` | {text} |" for name, text in _NUMBERS)
    suffix = SUFFIXES[distribution.form]
    with_what = "with numpy only" if distribution.form == "png" else "with numpy and imagecodecs"
    state = "each draw" if distribution.states is None else f"{distribution.states} states"
    mask = (
        f"pixels with at least {distribution.labels.mask_share:g} of the highest pixel of the target's own image in "
        f"band `{first['bands'][0]}`; box as x, y, width, height"
    )
    return f"""---
license: {distribution.licence}
---
# {distribution.title}

{frames} simulated infrared frames of {first["columns"]} x {first["rows"]} pixels in {layout.draws} sequences of
{layout.per_draw}, with {summary["targets"]} labels of targets, {summary["faint"]} of them with an SNR
below {FAINT_SNR:g} in every band; {summary["empty"]} frames have no target.
{size / 1e6:.1f} MB.

Licence: {distribution.licence}

| split | skies | frames |
|---|---|---|
{splits}

No sky is in two splits. {refused} of {layout.draws + refused} draws were refused as unphysical and drawn again.
Air, sun, sea and view are those of {state}.

## Radiance

Radiance in W m-2 sr-1 = offset + step x number:

| band | step | offset | largest number |
|---|---|---|---|
{scale}

Radiance comes from tables whose estimated error is at most {summary["table_error"]:.2g} of the total radiance of a
band; `table_error` in the labels of each frame. It is the error of interpolation and numerics, not that of the physics.

## Files

| file | content |
|---|---|
| `{SHARDS}/SPLIT-NNNNNN.tar` | WebDataset: `KEY.image{suffix}` (16 bits), `KEY.clean{suffix}`, `KEY.json` |
| `{SHARDS}/NNNNNN.jsonl` | index of a shard: sizes and hashes of its files, then the labels of its frames |
| `{TARGETS}` | one line for each target of each frame |
| `{ANNOTATIONS}/SPLIT.json` | COCO; images are those of the shards, extracted to one folder |
| `{MOT}/SPLIT/SEQUENCE/gt/gt.txt` | MOT ground truth, for sequences |
| `{CROISSANT}` | Croissant description of `{TARGETS}` |
| `{INDEX}` | some frames with boxes, for a browser |

`clean` is the same frame without targets and noise. The first row of an image is the southern one. Images of several
bands have their names: `KEY.image.BAND{suffix}`. In Python, {with_what}:
`from hcss_dataset import Frames; Frames("FOLDER", split="train")[0].image`.

## Labels of a target

| label | meaning |
|---|---|
| `mask`, `box` | {mask} |
{fields}

Clutter is measured in a square of {distribution.labels.window} pixels around the target. The targets' own
images are drawn by the sensor's optics without noise.
"""
