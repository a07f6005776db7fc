"""Damaged files of every kind that the package reads, and the functions that read them.

    python tests/stability/damage.py 10000 [KIND ...]     damage files 10000 times; list exceptions of other libraries

Each damage is determined by its seed. :func:`make_files` creates the files; :data:`READERS` has the functions.
"""

import json
import random
import shutil
import sys
import traceback
import warnings
from collections import Counter
from pathlib import Path

import netCDF4
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from cheap import CHEAP
from posterior_example import example_posterior

from hcss_twin.analysis.cloud_import import ImportOptions, import_image
from hcss_twin.analysis.comparison.evaluate import evaluate
from hcss_twin.analysis.uncertainty.posterior_file import read_posterior
from hcss_twin.core.catalog import Catalog, read_columns
from hcss_twin.core.errors import HcssError
from hcss_twin.cube.export.cube_export import export_cube
from hcss_twin.cube.reader import open_cube
from hcss_twin.engine.sense import sense_file
from hcss_twin.engine.simulate import run
from hcss_twin.engine.verification import verify_cube
from hcss_twin.models.atmosphere.imports.run import read_paths
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.clouds.database import read_entry, read_facts, write_entry
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.reports.cloud_columns import read_columns as read_cloud_columns
from hcss_twin.reports.preview import draw_preview
from hcss_twin.reports.report import report
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scenario.sensor import SensorSection

SMALL = CHEAP | {
    "image.rows": 12,
    "image.columns": 12,
    "frames.count": 2,
    "bands": ["lwir"],
    "output.certificate": 2,
    "output.variables": ["radiance", "truth", "brightness_temperature"],
}
SENSOR = {"parameters": {"noise": "nedt", "nedt": 0.05}}


def modtran6(size=5):
    """A case of MODTRAN 6 with made-up numbers."""
    frequency = [800.0 + 5.0 * each for each in range(size)]
    spectra = {"FREQ": frequency, "TOT_TRANS": [0.5] * size, "PTH_THRML": [1e-6] * size, "TOTAL_RAD": [2e-6] * size}
    geometry = {"H1ALT": 0.0, "H2ALT": 100.0, "OBSZEN": 180.0, "ITYPE": 2}
    inputs = {"GEOMETRY": geometry, "SPECTRAL": {"XFLAG": "W", "FWHM": 5.0}, "ATMOSPHERE": {"MODEL": "ATM_US_STD_1976"}}
    case = {"MODTRANINPUT": inputs, "MODTRANOUTPUT": {"SPECTRA": {"RADIANCE": spectra}}}
    return json.dumps({"MODTRAN": [case]}, indent=1)


def make_files(folder):
    """Write one file of each kind and return them by kind."""
    from PIL import Image as Picture

    folder.mkdir(parents=True, exist_ok=True)
    values = np.random.default_rng(1).integers(0, 255, (40, 40)).astype(np.uint8)
    np.save(folder / "image.npy", values)
    np.savez(folder / "image.npz", a=values)
    for suffix in ("png", "tif", "jpg"):
        Picture.fromarray(values).save(folder / f"image.{suffix}")
    with netCDF4.Dataset(folder / "image.nc", "w") as file:
        for name, size in (("y", 40), ("x", 40)):
            file.createDimension(name, size)
            axis = file.createVariable(name, "f8", (name,))
            axis.units, axis[:] = "m", np.arange(size) * 100.0
        plane = file.createVariable("Rad", "i2", ("y", "x"), zlib=True)
        plane.units, plane.long_name, plane.scale_factor, plane[:] = "W m-2 sr-1 um-1", "radiance", 0.5, values
    write_entry(folder / "entry.nc", import_image(folder / "image.npy", ImportOptions(pixel_size_m=100.0)))
    shutil.copy(Catalog().root / "atmospheres" / "us-standard-1976.csv", folder / "profile.csv")
    (folder / "response.csv").write_text("wavelength_um,response\n10,0\n10.5,1\n11,0.5\n12,0\n")
    (folder / "modtran.json").write_text(modtran6())
    (folder / "scene.toml").write_text(
        'title = "x"\ntime = "2024-04-20T12:30:00Z"\nseed = 3\n'
        'bands = ["lwir", {name = "mine", min = 3.5, max = 4.1}]\n[place]\nlatitude = 35.1\n[view]\nzenith = 20\n'
        '[clouds]\ntype = "stratus"\ncoverage = 0.4\n[sea]\nwind_speed = 5\n'
    )
    example_posterior(folder / "posterior.nc")
    raw = json.loads(Scenario.load("stratus").to_json())
    run(make_plan(Scenario.from_dict(raw, SMALL)), folder / "cube.nc")
    files = {path.name: path for path in sorted(folder.iterdir())}
    try:
        run(make_plan(Scenario.from_dict(raw, SMALL)), folder / "cube.zarr")
        files["cube.zarr"] = folder / "cube.zarr"
    except HcssError:
        pass  # without the package zarr
    return files


def _look_at(path):
    open_cube(path).close()  # what is loaded later is read by xarray, with errors of its own


def _report(path):
    report(path, path.with_suffix(".html"), replace=True)


READERS = {
    "cube": {
        "open": _look_at,
        "export": lambda path: export_cube(path, "png", path.parent / "exported", replace=True),
        "preview": lambda path: draw_preview(path, path.parent / "drawn", animation=False),
        "report": _report,
        "sense": lambda path: sense_file(path, SensorSection.model_validate(SENSOR), path.parent / "sensed.nc"),
        "verify": lambda path: verify_cube(path, frames=1),
        "columns": read_cloud_columns,
        "evaluate": lambda path: evaluate([path], [path]),
    },
    "cube.zarr": {"open": _look_at, "verify": lambda path: verify_cube(path, frames=1)},
    "image": {"image": read_image},
    "entry": {"entry": read_entry, "facts": read_facts},
    "profile": {"profile": lambda path: load_profile(str(path), Catalog())},
    "response": {"columns": read_columns},
    "modtran": {"paths": read_paths},
    "scene": {"scenario": Scenario.load},
    "posterior": {"posterior": read_posterior, "report": _report},
}


def readers_of(path):
    """Return what reads a file, by name."""
    return READERS.get(path.name) or READERS[path.stem]


WORDS = [b"", b"0", b"-1", b"1e999", b"nan", b"null", b"[]", b"{}", b"true", b'"x"', b"\xff", b"9" * 400, b"[" * 5000]


def damage(path, seed):
    """Damage a file, or one file of a folder, in place."""
    draw = random.Random(seed)
    if path.is_dir():
        path = draw.choice(sorted(each for each in path.rglob("*") if each.is_file()))
    if path.suffix == ".nc" and draw.random() < 0.5:
        return _damage_header(path, draw)
    data = bytearray(path.read_bytes())
    for _ in range(draw.choice([1, 1, 2, 8])):
        place, kind = draw.randrange(len(data) + 1), draw.randrange(6)
        if kind == 0 and data:
            data[min(place, len(data) - 1)] ^= 1 << draw.randrange(8)
        elif kind == 1:
            del data[place : place + draw.choice([1, 4, 100])]
        elif kind == 2:
            data[place:place] = draw.choice(WORDS)
        elif kind == 3:
            data[place : place + 8] = bytes(draw.randrange(256) for _ in range(8))
        elif kind == 4 and draw.random() < 0.3:
            del data[place:]
        elif path.suffix in (".json", ".csv", ".toml", "") or path.name.startswith(".z"):
            _replace_token(data, draw)
    path.write_bytes(data)
    return None


def _replace_token(data, draw):
    """Replace a word, a number or a bracket of a text."""
    import re

    tokens = [each.span() for each in re.finditer(rb'[\w.+-]+|"[^"]*"|\[[^\[\]]*\]|\{[^{}]*\}', bytes(data))]
    if tokens:
        first, last = draw.choice(tokens)
        data[first:last] = draw.choice(WORDS)


def _damage_header(path, draw):
    """Change an attribute, a value or a name of a NetCDF file to one of another kind."""
    values = ["", "x", "{}", "[]", '{"a": 1}', np.float64("nan"), np.int32(-1), 1e300, np.arange(3.0), "\x00", "9" * 99]
    with netCDF4.Dataset(path, "a") as file:
        owners = [file, *file.variables.values()]
        owner = draw.choice(owners)
        names = owner.ncattrs()
        kind = draw.randrange(4)
        if kind == 0 and names:
            owner.delncattr(draw.choice(names))
        elif kind == 1 and file.variables:
            file.renameVariable(draw.choice(sorted(file.variables)), "other")
        elif kind == 2 and owner is not file and owner.dtype is not str and owner.dtype.kind in "fiu" and owner.size:
            owner.set_auto_mask(False)
            owner[...] = draw.choice([0, 1, 100])
        elif names:
            name = draw.choice(names)
            if name not in ("_FillValue",):
                value = owner.getncattr(name)
                if isinstance(value, str) and value.startswith(("{", "[")) and draw.random() < 0.7:
                    text = bytearray(value.encode())
                    _replace_token(text, draw)
                    owner.setncattr(name, text.decode(errors="replace").replace("\0", ""))
                else:
                    owner.setncattr(name, draw.choice(values))


def what_escapes(files, folder, count, seed=0, kinds=()):
    """Damage files ``count`` times; return exceptions other than the package's, by reader, and how many were read."""
    escaped, outcomes = {}, Counter()
    chosen = [path for path in files.values() if not kinds or path.stem in kinds or path.name in kinds]
    for number in range(seed, seed + count):
        draw = random.Random(number)
        path = draw.choice(chosen)
        copy = folder / path.name
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(path, copy) if path.is_dir() else shutil.copy(path, copy)
        try:
            damage(copy, number)
        except Exception:  # the library that damages refuses
            outcomes["not damaged"] += 1
            continue
        name, reader = draw.choice(sorted(readers_of(copy).items()))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                reader(copy)
            outcomes["read"] += 1
        except HcssError:
            outcomes["refused"] += 1
        except Exception as error:
            outcomes["escaped"] += 1
            last = traceback.extract_tb(error.__traceback__)[-1]
            escaped.setdefault(
                (path.name, name, type(error).__name__, f"{last.name}:{last.lineno}"), (number, str(error))
            )
    return escaped, outcomes


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as temporary:
        there = Path(temporary)
        made = make_files(there / "files")
        found, counts = what_escapes(made, there, int(sys.argv[1]), kinds=sys.argv[2:])
    for where, (number, text) in sorted(found.items()):
        print(*where, f"seed {number}:", text[:200])
    print(dict(counts))
