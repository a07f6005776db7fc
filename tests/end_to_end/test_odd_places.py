"""File names that are not text, folders without write permission, ASCII-only terminals, numbers near 0."""

import os
import subprocess
import sys

import pytest
from cheap import CHEAP_OPTIONS
from example_cube import example_frame, example_header

from hcss_twin.core.errors import CubeError, HcssError, ScenarioError
from hcss_twin.core.files import Writing
from hcss_twin.cube.writer import CubeWriter
from hcss_twin.reports.preview import draw_preview
from hcss_twin.scenario.scenario import Scenario

ODD = os.fsdecode(b"caf\xe9.nc")
"""A file name that is not UTF-8."""


def test_a_name_that_is_not_utf_8_is_refused_with_the_name(tmp_path):
    with pytest.raises(CubeError, match=r"cannot write .*utf-8"), CubeWriter(tmp_path / ODD, example_header()):
        pass

    def fail():
        with Writing(tmp_path / ODD, HcssError):
            ODD.encode()

    with pytest.raises(HcssError, match="cannot write"):
        fail()
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(os.name == "nt", reason="names of POSIX")
@pytest.mark.parametrize("changes", [{}, {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}])
def test_an_odd_name_is_shown_on_any_terminal(tmp_path, changes):
    command = [sys.executable, "-m", "hcss_twin", "validate", os.fsencode(ODD), *CHEAP_OPTIONS]
    done = subprocess.run(command, cwd=tmp_path, env=os.environ | changes, capture_output=True)
    assert done.returncode == 2
    assert b".nc: 1 problem" in done.stderr
    assert b"Traceback" not in done.stderr


def test_pictures_are_not_written_where_there_is_no_folder(tmp_path):
    path, header = tmp_path / "c.nc", example_header()
    with CubeWriter(path, header) as writer:
        for index in range(header.frames):
            writer.write_frame(index, example_frame(header, index))
    with pytest.raises(CubeError, match=r"cannot write to .*inside: Not a directory"):
        draw_preview(path, path / "inside")


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="the superuser may write anywhere")
def test_pictures_are_not_written_into_a_read_only_folder(tmp_path):
    path, header = tmp_path / "c.nc", example_header()
    with CubeWriter(path, header) as writer:
        for index in range(header.frames):
            writer.write_frame(index, example_frame(header, index))
    (tmp_path / "fixed").mkdir(mode=0o500)
    with pytest.raises(CubeError, match=r"cannot write .*Permission denied"):
        draw_preview(path, tmp_path / "fixed")


@pytest.mark.parametrize("key", ["clouds.effective_radius", "image.pixel_size"])
def test_numbers_near_zero_are_out_of_range(key):
    with pytest.raises(ScenarioError, match=rf"{key}: 5e-324 is out of range; allowed: >= 0\.001"):
        Scenario.load("stratus", {key: 5e-324})
