"""``index.html``: frames with boxes at the places of labels, and its filters in a browser."""

import base64
import io
import re
import shutil
import subprocess

import numpy as np
import pytest
from hcss_dataset import Frames
from hcss_dataset.make import make_dataset
from hcss_dataset.viewer import grey
from PIL import Image
from sets import keys

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
RECT = re.compile(r'<rect class="target" x="(-?\d+)" y="(-?\d+)" width="(\d+)" height="(\d+)"')


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("viewed")
    make_dataset(keys({"image.rows": 32, "image.columns": 24, "frames.count": 1}), folder, 12)
    return folder


def test_each_box_is_drawn_around_its_target_with_north_up(whole):
    figures = (whole / "index.html").read_text().split("<figure")[1:]
    frames = list(Frames(whole))
    assert len(figures) == len(frames) == 12
    for figure, frame in zip(figures, frames, strict=True):
        boxes = [tuple(int(each) for each in found) for found in RECT.findall(figure)]
        expected = [each["box"] for each in frame.labels["targets"]]
        assert boxes == [(x - 3, 32 - y - height - 3, width + 6, height + 6) for x, y, width, height in expected]
        picture = re.search(r"base64,([^\"]+)", figure)[1]
        with Image.open(io.BytesIO(base64.b64decode(picture))) as opened:
            assert np.array_equal(np.array(opened), grey(frame.image[0])[::-1])
        assert f'data-split="{frame.labels["split"]}"' in figure


@pytest.mark.long
@pytest.mark.skipif(BROWSER is None, reason="no chromium, chromium-browser or google-chrome is installed")
@pytest.mark.parametrize("wanted", ["with", "without"])
def test_filters_hide_frames(whole, tmp_path, wanted):
    choose = f"const f = document.querySelector('[data-filter=targets]'); f.value = '{wanted}'; "
    choose += "f.dispatchEvent(new Event('input'));"
    page = tmp_path / "page.html"
    page.write_text((whole / "index.html").read_text().replace("</body>", f"<script>{choose}</script></body>"))
    options = ["--headless=new", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path}", "--dump-dom"]
    shown = subprocess.run([BROWSER, *options, page.as_uri()], capture_output=True, text=True, timeout=120).stdout
    count = sum(bool(frame.labels["targets"]) == (wanted == "with") for frame in Frames(whole))
    assert 0 < count < 12
    assert f'<b id="shown">{count}</b>' in shown
    assert len(re.findall(r"<figure[^>]*display: none", shown)) == 12 - count
