"""Shards: the same bytes wherever they are made, none half made, no sky in two splits; and the files over them."""

import hashlib
import json
import sys
import tarfile

import numpy as np
import pytest
from hcss_dataset import DatasetError, Frames, shards
from hcss_dataset.distribution import Distribution
from hcss_dataset.images import decoded, encoded
from hcss_dataset.make import make_dataset
from hcss_dataset.rendering import Studio
from hcss_dataset.shards import Layout
from sets import keys

SMALL = keys({"image.rows": 24, "image.columns": 20, "frames.count": 2}, reuse={"draws_per_sky": 2},
             split={"train": 0.5, "val": 0.25, "test": 0.25}, licence="CC-BY-4.0")  # fmt: skip
FRAMES = 24


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A data set of three shards."""
    folder = tmp_path_factory.mktemp("set")
    made = make_dataset(SMALL, folder, FRAMES)
    assert (made.frames, made.missing) == (FRAMES, 0)
    return folder


THEIRS = pytest.mark.filterwarnings(
    "ignore::DeprecationWarning", "ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning"
)
"""Warnings of the code of other packages."""


def reader(name):
    """Return a module that a data set is made for."""
    return pytest.importorskip(name, reason=f"{name} is not installed: pip install 'hcss-dataset[readers]'")


def digests(folder):
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def test_a_shard_made_alone_has_the_same_bytes(whole, tmp_path):
    for shard in (2, 0, 1):
        made = make_dataset(SMALL, tmp_path, FRAMES, shard=shard)
        assert made.frames == 8
    assert made.missing == 0
    assert digests(tmp_path) == digests(whole)


@pytest.mark.long
def test_workers_make_the_same_bytes(whole, tmp_path):
    make_dataset(SMALL, tmp_path, FRAMES, workers=2)
    assert digests(tmp_path) == digests(whole)


def test_what_was_interrupted_is_made_again_and_nothing_else(whole, tmp_path, monkeypatch):
    class Killed(BaseException):
        pass

    images = []

    def interrupted(image, form):
        images.append(image)
        if len(images) == 4 * 12:  # image and clean of two bands: within the second shard
            raise Killed
        return encoded(image, form)

    with monkeypatch.context() as patch:
        patch.setattr(shards, "encoded", interrupted)
        with pytest.raises(Killed):
            make_dataset(SMALL, tmp_path, FRAMES)
    there = {path.name for path in (tmp_path / "shards").iterdir()}
    assert {name[:6] for name in there if name.endswith(".jsonl")} == {"000000"}
    assert all("000000" in name for name in there)
    assert not (tmp_path / "README.md").exists()
    assert make_dataset(SMALL, tmp_path, FRAMES).frames == 16
    assert digests(tmp_path) == digests(whole)


def test_a_shard_that_lost_a_file_is_made_again(whole, tmp_path):
    make_dataset(SMALL, tmp_path, FRAMES, shard=1)
    layout = Layout(tmp_path, Distribution.load(SMALL), FRAMES // 2, 2)
    assert layout.missing() == [0, 2]
    tar = next((tmp_path / "shards").glob("*-000001.tar"))
    tar.write_bytes(tar.read_bytes()[:-512])
    assert layout.missing() == [0, 1, 2]


def test_a_folder_of_another_set_is_left_alone(whole):
    before = digests(whole)
    with pytest.raises(DatasetError, match="another distribution"):
        make_dataset(SMALL | {"seed": 4}, whole, FRAMES)
    with pytest.raises(DatasetError, match="another number of frames"):
        make_dataset(SMALL, whole, FRAMES + 2)
    assert digests(whole) == before


def test_no_sky_is_in_two_splits(whole):
    splits = {}
    for frame in Frames(whole):
        splits.setdefault(frame.labels["sky"], set()).add(frame.labels["split"])
        assert frame.labels["file"].startswith(frame.labels["split"])
    assert len(splits) == FRAMES // 4
    assert all(len(found) == 1 for found in splits.values())
    assert len({name for found in splits.values() for name in found}) > 1


def test_frames_are_read_as_they_were_made(whole):
    frames, studio = Frames(whole), Studio(Distribution.load(SMALL))
    assert len(frames) == FRAMES
    number = next(n for n, frame in enumerate(frames) if frame.labels["targets"])
    made = [*studio.sequence(number // 2).frames()][number % 2]
    assert np.array_equal(frames[number].image, made.image)
    assert np.array_equal(frames[number].clean, made.clean)
    assert frames[number].labels["targets"] == json.loads(json.dumps(made.labels["targets"]))
    target = made.labels["targets"][0]
    assert frames[number].mask(0).sum() == sum(target["mask"]["counts"][1::2])
    radiance = frames[number].radiance(frames[number].clean)
    assert radiance == pytest.approx(studio.sequence(number // 2).scale.radiance(made.clean))
    parts = {split: len(Frames(whole, split)) for split in ("train", "val", "test")}
    assert sum(parts.values()) == FRAMES


def test_a_shard_is_a_plain_tar_file_without_dates(whole):
    for path in (whole / "shards").glob("*.tar"):
        with tarfile.open(path) as tar:
            members = tar.getmembers()
        assert {each.mtime for each in members} == {0}
        suffixes = {each.name.partition(".")[2] for each in members}
        assert suffixes == {"image.mwir.png", "image.lwir.png", "clean.mwir.png", "clean.lwir.png", "json"}


def test_the_card_states_licence_scale_error_and_splits(whole):
    card, frame = (whole / "README.md").read_text(), Frames(whole)[0]
    assert "Licence: CC-BY-4.0" in card
    assert f"| mwir | {frame.labels['radiance_per_number'][0]:.6g} |" in card
    largest = max(each.labels["table_error"] for each in Frames(whole))
    assert f"at most {largest:.2g} of the total radiance" in card
    for split in ("train", "val", "test"):
        assert (f"| {split} |" in card) == bool(len(Frames(whole, split)))
    best = [max(target["snr"]) for frame in Frames(whole) for target in frame.labels["targets"]]
    faint = sum(snr < 3.0 for snr in best)
    assert f"{len(best)} labels of targets, {faint} of them with an SNR below 3" in card.replace("\n", " ")


def test_lines_of_targets_are_those_of_the_frames(whole):
    lines = [json.loads(line) for line in (whole / "targets.jsonl").read_text().splitlines()]
    labels = [(frame.labels["key"], target) for frame in Frames(whole) for target in frame.labels["targets"]]
    assert [(line["key"], line["track"], line["centroid"]) for line in lines] == [
        (key, target["track"], target["centroid"]) for key, target in labels
    ]


def test_tracks_of_mot_are_the_boxes_of_the_labels(whole):
    found = 0
    for path in (whole / "mot").rglob("gt.txt"):
        draw = int(path.parents[1].name)
        for line in path.read_text().splitlines():
            frame, track, x, y, width, height, *_ = (float(each) for each in line.split(","))
            labels = Frames(whole)[2 * draw + int(frame) - 1].labels
            target = next(each for each in labels["targets"] if each["track"] == track)
            assert target["box"] == [x - 1, y - 1, width, height]
            found += 1
    assert found == sum(target["box"] is not None for each in Frames(whole) for target in each.labels["targets"])


@pytest.mark.parametrize(("form", "suffix", "words"), [("png", ".png", "damaged"), ("jpegxl", ".jxl", "no JPEG XL")])
def test_images_of_16_bits_come_back(form, suffix, words):
    if form == "jpegxl":
        reader("imagecodecs")
    image = np.random.default_rng(0).integers(0, 2**16, (7, 13)).astype(np.uint16)
    assert np.array_equal(decoded(encoded(image, form), suffix), image)
    broken = bytearray(encoded(image, form))
    broken[60] ^= 1
    for file in (bytes(broken), encoded(image, form)[:-20])[form == "jpegxl" :]:  # JPEG XL has no checksums
        with pytest.raises(ValueError, match=words):
            decoded(file, suffix)


def test_a_set_in_jpeg_xl_has_the_same_images(whole, tmp_path):
    reader("imagecodecs")
    make_dataset(SMALL | {"image": {"format": "jpegxl"}}, tmp_path, FRAMES, shard=0)
    layout = Layout(tmp_path, Distribution.load(SMALL), FRAMES // 2, 2)
    for one, other in zip(Frames(tmp_path), Frames(whole), strict=False):
        assert np.array_equal(one.image, other.image)
        assert np.array_equal(one.clean, other.clean)
        assert one.labels["targets"] == other.labels["targets"]
        assert {name.rpartition(".")[2] for name in one.labels["images"]} == {"jxl"}
    assert len(Frames(tmp_path)) == 8
    assert layout.tar(0, Frames(tmp_path)[0].labels["split"]).is_file()


def test_without_its_package_a_format_is_refused_before_anything_is_written(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imagecodecs", None)
    with pytest.raises(DatasetError, match=r"pip install 'hcss-dataset\[jpegxl\]'.*allowed without it: 'png'"):
        make_dataset(SMALL | {"image": {"format": "jpegxl"}}, tmp_path / "set", FRAMES)
    assert not (tmp_path / "set").exists()


def test_other_programs_read_the_images(whole):
    from PIL import Image

    path = next((whole / "shards").glob("train-*.tar"))
    with tarfile.open(path) as tar:
        name = tar.getmembers()[0].name
        with Image.open(tar.extractfile(name)) as opened:
            seen = np.array(opened)
    frame = next(each for each in Frames(whole) if name.startswith(each.labels["key"]))
    assert np.array_equal(seen, frame.image[0])


@THEIRS
def test_pycocotools_reads_boxes_and_masks(whole):
    coco = reader("pycocotools.coco")
    for path in (whole / "annotations").glob("*.json"):
        opened = coco.COCO(str(path))
        assert len(opened.getImgIds()) == len(Frames(whole, path.stem))
        for annotation in opened.loadAnns(opened.getAnnIds()):
            frame = Frames(whole)[annotation["image_id"]]
            places = [target["track"] for target in frame.labels["targets"]]
            mask = frame.mask(places.index(annotation["track_id"]))
            assert np.array_equal(opened.annToMask(annotation).astype(bool), mask)
            assert annotation["area"] == mask.sum()


@THEIRS
def test_webdataset_reads_frames_with_their_labels(whole):
    webdataset = reader("webdataset")
    path = next((whole / "shards").glob("train-*.tar"))
    found = list(webdataset.WebDataset(str(path), shardshuffle=False, empty_check=False).decode())
    expected = [each for each in Frames(whole, "train") if each.labels["file"] == path.name]
    assert [each["__key__"] for each in found] == [each.labels["key"] for each in expected]
    for sample, frame in zip(found, expected, strict=True):
        assert sample["json"]["targets"] == frame.labels["targets"]
        assert np.array_equal(decoded(sample["image.mwir.png"], ".png"), frame.image[0])


@THEIRS
def test_mlcroissant_reads_the_targets(whole):
    croissant = reader("mlcroissant")
    opened = croissant.Dataset(jsonld=str(whole / "croissant.json"))
    records = list(opened.records("targets"))
    lines = [json.loads(line) for line in (whole / "targets.jsonl").read_text().splitlines()]
    assert len(records) == len(lines) > 0
    for record, line in zip(records, lines, strict=True):
        assert record["targets/altitude_m"] == line["altitude_m"]
        assert record["targets/track"] == line["track"]
        assert record["targets/key"].decode() == line["key"]
