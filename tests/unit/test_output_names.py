"""One check of output names for all commands, and files of users that no output replaces or deletes."""

import json
import os

import click
import numpy as np
import pytest
from click.testing import CliRunner
from distributions import need
from example_cube import example_frame, example_header

from hcss_twin.cli.main import cli
from hcss_twin.cli.options import Output
from hcss_twin.core.errors import CubeError, HcssError
from hcss_twin.core.files import FORMS, Writing
from hcss_twin.cube.reader import open_cube
from hcss_twin.cube.requested_variables import expand
from hcss_twin.cube.zarr_writer import ZarrWriter

OUTPUTS = {"output", "json_file", "plot", "preview", "occupancy", "dataset", "picture"}


def commands(group, words=()):
    """Yield (words, command) of all commands, those of plugins included."""
    context = click.Context(group)
    of_plugins = group.plugin_commands()[0] if group is cli else ()
    for name in (*group.list_commands(context), *of_plugins):
        command = group.get_command(context, name)
        if isinstance(command, click.Group):
            yield from commands(command, (*words, *name.split()))
        if command is not None:
            yield (*words, *name.split()), command


def test_all_outputs_of_all_commands_are_checked():
    files = [
        (words, each)
        for words, command in commands(cli)
        for each in command.params
        if each.name in OUTPUTS and isinstance(each.type, click.Path) and each.type.file_okay
    ]
    assert len(files) >= 6  # those of plugins come to these
    assert [(words, each.name) for words, each in files if not isinstance(each.type, Output)] == []


@pytest.mark.parametrize("form", sorted(set(FORMS) - {"other"}))
def test_a_name_has_the_suffix_of_its_form_or_of_none(tmp_path, form):
    known = {suffix for suffixes in FORMS.values() for suffix in suffixes}
    for suffix in known | {each.upper() for each in known}:
        path = tmp_path / f"cube{suffix}"
        if suffix.lower() in FORMS[form]:
            Writing(path, HcssError, form).check()
        else:
            with pytest.raises(HcssError, match=f"not {suffix.lower()}; closest is .*cube{FORMS[form][0]}"):
                Writing(path, HcssError, form).check()
    Writing(tmp_path / "cube", HcssError, form).check()


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("x.zarr", "the output is NetCDF, not .zarr; closest is x.nc"),
        ("x.nc/", "a folder that does not exist"),
        ("-", "allowed: the name of a file"),
        ("", "allowed: the name of a file"),
        ("/dev/null", "it is a device"),
        ("taken", "it is a folder|is a directory"),
        ("no/x.nc", "there is no folder"),
        ("image.npy", "exists; give another name with -o, or --force"),
        ("link.nc", "exists; give another name with -o, or --force"),
    ],
)
def test_a_name_that_does_not_do_is_refused_before_anything_is_computed(tmp_path, monkeypatch, name, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").mkdir()
    (tmp_path / "link.nc").symlink_to("nowhere")
    np.save("image.npy", np.ones((8, 8)))
    done = CliRunner().invoke(cli, ["atmosphere", "import", "image.npy", "-o", name])
    text = done.output + str(done.exception)
    assert done.exit_code != 0
    assert any(each in " ".join(text.split()) for each in message.split("|")), text


@pytest.mark.parametrize("link", [None, os.link, os.symlink])
@pytest.mark.parametrize(
    "words",
    [
        ["import", "mine.npy", "--name", "out", "--to", "."],
        ["match", "mine.npy", "-o", "out.toml"],
        ["atmosphere", "import", "mine.npy", "-o", "out.nc"],
        ["evaluate", "mine.npy", "mine.npy", "-o", "out.html"],
        ["fit", "mine.npy", "-o", "out.nc"],
        ["skies", "import", "mine.npy", "-o", "out.nc"],
    ],
    ids=lambda words: "-".join(words[:2]),
)
def test_no_command_replaces_what_it_reads(tmp_path, monkeypatch, words, link):
    if words[0] == "skies":
        need("hcss-skies")
    monkeypatch.chdir(tmp_path)
    output = next((word for word in words if word.startswith("out.")), "out.nc")
    np.save("mine.npy", np.random.default_rng(0).random((40, 40)))
    (os.rename if link is None else link)("mine.npy", output)
    words = [output if word == "mine.npy" and link is None else word for word in words]
    before = (tmp_path / output).read_bytes()
    done = CliRunner().invoke(cli, [*words, "--force"])
    assert "it is an input of this command" in str(done.exception), done.output
    assert (tmp_path / output).read_bytes() == before


def write_store(path):
    header = example_header(variables=tuple(expand(["radiance"], {}, layer_count=2, shadows=False)))
    with ZarrWriter(path, header) as cube:
        for index in range(header.sizes["time"]):
            cube.write_frame(index, example_frame(header, index))


def test_files_of_the_user_in_a_store_outlive_its_replacement(tmp_path):
    store = tmp_path / "cube.zarr"
    write_store(store)
    mine = ("notes.txt", "radiance/thesis.txt", "figures/a/b.png", ".hidden", "extra/.zarray", "extra/0.0")
    for name in mine:
        (store / name).parent.mkdir(parents=True, exist_ok=True)
        (store / name).write_text(name)
    write_store(store)
    assert [name for name in mine if (store / name).read_text() != name] == []
    assert [each.name for each in tmp_path.iterdir()] == ["cube.zarr"]
    open_cube(store).close()


def test_a_store_of_others_is_not_replaced_and_a_link_to_one_is_not_followed(tmp_path):
    store = tmp_path / "cube.zarr"
    write_store(store)
    attributes = json.loads((store / ".zattrs").read_text())
    foreign = {name: value for name, value in attributes.items() if name != "hcss_cube_format"}
    assert foreign != attributes
    (store / ".zattrs").write_text(json.dumps(foreign))
    before = sorted(store.rglob("*"))
    with pytest.raises(CubeError, match="not a Zarr store with a cube"):
        write_store(store)
    assert sorted(store.rglob("*")) == before
    (store / ".zattrs").write_text(json.dumps(attributes))
    link = tmp_path / "link.zarr"
    link.symlink_to(store)
    write_store(link)
    assert not link.is_symlink()
    assert sorted(store.rglob("*")) == before
    assert sorted(each.name for each in tmp_path.iterdir()) == ["cube.zarr", "link.zarr"]


def test_only_drafts_of_this_package_are_removed(tmp_path):
    (tmp_path / ".thesis.docx.partial").write_text("mine")
    Writing.remove_orphans(tmp_path, every=True)
    assert [each.name for each in tmp_path.iterdir()] == [".thesis.docx.partial"]


def test_a_file_with_other_contents_is_not_replaced(tmp_path):
    path = tmp_path / "x.nc"
    for contents in (b"my notes", b"\x89PNG", b"\x89H"):
        path.write_bytes(contents)
        with pytest.raises(HcssError, match="the file there is no NetCDF"), Writing(path, HcssError, "NetCDF"):
            pass
        assert path.read_bytes() == contents
