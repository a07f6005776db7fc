"""What ``hcss evaluate`` writes."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from evaluation_images import FOUR, clouds, hcss

from hcss_twin import HcssError
from hcss_twin.core.catalog import Catalog


class Addresses(HTMLParser):
    """What a page asks for, and its words."""

    def __init__(self):
        super().__init__()
        self.addresses, self.alternatives, self.text = [], [], ""

    def handle_starttag(self, tag, attrs):
        self.addresses += [value for name, value in attrs if name in ("src", "href")]
        self.alternatives += [value for name, value in attrs if name == "alt"]

    def handle_data(self, data):
        self.text += data


def test_the_command_writes_a_table_a_page_and_json_that_agree(cube, seviri, tmp_path):
    page, numbers = tmp_path / "report.html", tmp_path / "numbers.json"
    arguments = ("evaluate", seviri, cube, "--sim-band", "lwir-10.8", "--sim-frames", "0-1")
    done = hcss(*arguments, "-o", page, "--json", numbers)
    assert done.exit_code == 0, done.output
    told = json.loads(numbers.read_text(encoding="utf-8"))
    rmse = f"{100 * told['eq24']['as-printed']['RMSE']:.2f} %"
    assert f"as-printed ~  {rmse}, relative to the simulated values" in done.output
    assert {metric["name"] for metric in told["metrics"]} >= {*FOUR, "coverage", "degree", "long axis", "mean"}
    assert set(told["definitions"]) == {"EV", "Den", "DP", "FD", "RMSE"}
    assert told["unit"] == "K"
    assert len(told["sim"]["frames"]) == 2
    assert sum(told["real"]["histogram"]) == pytest.approx(1.0)
    assert len(told["histogram_edges"]) == len(told["sim"]["histogram"]) + 1
    found = Addresses()
    found.feed(page.read_text(encoding="utf-8"))
    assert all(address.startswith(("data:", "#")) for address in found.addresses)
    assert rmse in found.text
    for word in ("two-dimensional histogram", "power spectra", "direction", "correlation", "grey levels"):
        assert any(word in alternative for alternative in found.alternatives), word
    again = hcss(*arguments, "-o", page)
    assert again.exit_code == 1
    assert "exists; give another name, or --force" in again.output


def test_json_to_the_screen_is_all_that_is_written_there(save):
    path = save("a.npy", clouds(1))
    done = hcss("evaluate", path, path, "--json", "-")
    assert json.loads(done.output)["eq24"]["corrected"]["RMSE"] == 0.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--coverage", "0.5"], "--coverage: allowed with method coverage only"),
        (["--window", "9"], "--window: allowed with method local only"),
        (["--sim-frames", "3-1"], "'3-1' given, allowed: numbers and ranges"),
        (["-o", "x.html", "--json", "x.html"], "are both x.html"),
        (["-o", "nowhere/x.html"], "there is no folder"),
    ],
)
def test_command_lines_that_contradict_themselves_are_refused(save, options, message):
    path = save("a.npy", clouds(1))
    done = hcss("evaluate", path, path, *options)
    assert done.exit_code != 0
    assert message in done.output


def test_what_one_side_needs_is_not_asked_of_the_other(save, cube):
    path = save("a.npy", clouds(1))
    done = hcss(
        "evaluate", path, cube, "--real-method", "coverage", "--coverage", "0.25", "--sim-method", "truth",
        "--sim-band", "mwir", "--json", "-",
    )  # fmt: skip
    told = json.loads(done.output)
    assert (told["real"]["method"], told["sim"]["method"]) == ("coverage", "truth")
    assert told["real"]["frames"][0]["coverage"] > 0.0


def test_a_file_of_several_images_names_the_option_and_the_image_that_can_be_compared():
    entry = Catalog().find("made-cirrus", "clouds", ".nc")
    for side, earlier in (("real", []), ("sim", ["--real-variable", "image"])):
        done = hcss("evaluate", entry, entry, *earlier, catch=True)
        assert re.search(rf"--{side}-variable\) to one of: .*'image' is the imported one", str(done.exception))
    assert hcss("evaluate", entry, entry, "--real-variable", "image", "--sim-variable", "image").exit_code == 0


def test_a_failed_evaluation_leaves_no_file(save, tmp_path):
    np.save(tmp_path / "constant.npy", np.ones((64, 64)))
    done = hcss(
        "evaluate", save("a.npy", clouds(1)), tmp_path / "constant.npy", "-o", tmp_path / "r.html",
        "--json", tmp_path / "r.json", catch=True,
    )  # fmt: skip
    assert isinstance(done.exception, HcssError)
    assert not list(tmp_path.glob("*.html"))
    assert not list(tmp_path.glob("*.json"))
