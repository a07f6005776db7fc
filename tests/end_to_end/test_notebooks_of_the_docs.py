"""Notebooks of the documentation are run, cell by cell, as a reader would."""

import base64
import io
import re
from pathlib import Path

import nbformat
import numpy as np
import pytest
from nbclient import NotebookClient
from PIL import Image

import hcss_twin
from hcss_twin.core.environment import COMPILING

FOLDER = Path(__file__).parents[2] / "docs" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


@pytest.fixture(scope="module", params=NOTEBOOKS, ids=lambda path: path.stem)
def run(request, tmp_path_factory):
    """A notebook as committed, and after its cells were run in an empty folder."""
    committed, notebook = (nbformat.read(request.param, as_version=4) for _ in range(2))
    NotebookClient(
        notebook, timeout=120, resources={"metadata": {"path": str(tmp_path_factory.mktemp("notebook"))}}
    ).execute()
    return committed, notebook


def outputs(notebook, kind):
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    found = [part.get("data", {}).get(kind) for cell in cells for part in cell.outputs]
    return [part for part in found if part is not None]


def test_notebooks_are_committed_without_outputs(run):
    committed, _ = run
    nbformat.validate(committed)
    assert all(cell.execution_count is None and not cell.outputs for cell in committed.cells if "outputs" in cell)


def test_every_cell_that_computes_shows_something(run):
    _, notebook = run
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell.source.splitlines()[0] for cell in cells if not cell.outputs] == []
    errors = [part.get("text", "") for cell in cells for part in cell.outputs if part.get("name") == "stderr"]
    assert "".join(errors).replace(f"{COMPILING}\n", "") == ""


def test_pictures_have_structure_and_tables_are_html(run):
    _, notebook = run
    pictures = outputs(notebook, "image/png")
    assert len(pictures) == 2
    for picture in pictures:
        with Image.open(io.BytesIO(base64.b64decode(picture))) as image:
            grey = np.asarray(image.convert("L"))
        assert len(np.unique(grey)) > 50
    assert len(outputs(notebook, "text/html")) >= 2  # the scenario and the plan


def test_numbers_that_are_printed_are_those_of_the_command_line_cube(run):
    """Computed here again, with numpy instead of the cells."""
    _, notebook = run
    text = "".join(
        part.text for cell in notebook.cells for part in cell.get("outputs", ()) if part.get("name") == "stdout"
    )
    printed = re.search(r"clear ([\d.]+) K, cloud ([\d.]+) K, cover ([\d.]+)", text)
    assert printed
    size = {"image.rows": 120, "image.columns": 160, "image.pixel_size": 50.0}
    cube = hcss_twin.simulate("stratus", overrides={**size, "frames.count": 2, "bands": ["lwir"]})
    kelvin, mask = hcss_twin.brightness_temperature(cube).to_numpy()[:, 0], cube.cloud_mask.to_numpy() == 1
    expected = kelvin[~mask].mean(dtype=float), kelvin[mask].mean(dtype=float), mask.mean()
    np.testing.assert_allclose([float(number) for number in printed.groups()], expected, atol=0.051)
    assert "computed as specified" in text
