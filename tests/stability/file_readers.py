"""What reads each of the files of ``input_files.py``: functions of the path, by file and purpose."""

import os
from dataclasses import replace

import numpy as np
from hcss_author import sample_surface_inputs
from hcss_evaluate.errors import PosteriorError
from hcss_evaluate.posterior.fit import fit
from hcss_evaluate.posterior.posterior_file import read_posterior
from hcss_export import export_cube
from hcss_modtran.importing import read_paths
from hcss_sweep.dataset import open_sweep
from hcss_sweep.design import Design
from hcss_sweep.points import points_of
from hcss_sweep.run import sweep
from hcss_uncertainty.dataset import open_propagation
from hcss_uncertainty.joint_sample import PosteriorDraws
from input_files import FIT, SENSOR, SWEPT, noise, optics_table, small_stratus

from hcss_twin.core.catalog import Catalog, read_columns
from hcss_twin.cube.reader import open_cube
from hcss_twin.engine.sense import sense_file
from hcss_twin.engine.simulate import simulate
from hcss_twin.engine.verification import verify_cube
from hcss_twin.models.atmosphere.profile_file import load_profile, load_profiles
from hcss_twin.models.atmosphere.table_file import AtmosphereTable
from hcss_twin.models.clouds.database import CloudEntry
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.models.optics.table_store import read_into
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.models.sensor.point_spread import read_kernel
from hcss_twin.models.surfaces.parameters import RasterParameters
from hcss_twin.models.surfaces.raster import Raster
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.reports.cloud_columns import read_columns as read_cloud_columns
from hcss_twin.reports.preview import draw_preview
from hcss_twin.reports.report import report
from hcss_twin.scenario.response_file import read_response
from hcss_twin.scenario.scenario import Scenario


def _look_at(path):
    open_cube(path).close()  # what is loaded later is read by xarray, with errors of its own


def _report(path):
    report(path, path.with_suffix(".html"), replace=True)


def _raster(path):
    inputs = replace(sample_surface_inputs(), catalog=Catalog(base=path.parent))
    raster = Raster(inputs, RasterParameters(file=path.name, classes={0: "sea", 1: "ice"}))
    raster.surface(0.0, slice(0, 4), slice(0, 5))


def _resume(path):
    result = sweep(small_stratus(), path, over=SWEPT)
    assert len(result.points) == 2


def _fit_on(path):
    """Go on with a fit; it has had all its steps, so that it ends at once."""
    state = path.with_name("fit.nc.state")
    path.replace(state)
    image = path.with_name("fitted.npy")
    np.save(image, noise())
    try:
        fit(image, path.with_name("fit.nc"), **FIT)
    except PosteriorError as error:
        if "not converged" not in str(error):
            raise
    finally:
        state.unlink(missing_ok=True)


def _with_what_was_kept(path):
    """A run with a damaged cache gives the same radiance."""
    before = os.environ.get("HCSS_CACHE_DIR")
    os.environ["HCSS_CACHE_DIR"] = str(path)
    try:
        radiance = simulate(small_stratus()).radiance.values
    finally:
        del os.environ["HCSS_CACHE_DIR"]
        if before is not None:
            os.environ["HCSS_CACHE_DIR"] = before
    with open_cube(path.parent / "files" / "cube.nc") as cube:
        np.testing.assert_array_equal(radiance, cube.radiance.values)


_CUBE = {
    "open": _look_at,
    "export": lambda path: export_cube(path, "png", path.parent, replace=True),
    "preview": lambda path: draw_preview(path, path.parent, animation=False, frames=1),
    "sense": lambda path: sense_file(path, SENSOR, path.parent / "sensed.nc"),
    "verify": lambda path: verify_cube(path, frames=1),
    "columns": read_cloud_columns,
}

FAST = {
    **{f"image.{suffix}": {"image": read_image} for suffix in ("jpg", "nc", "npy", "npz", "png", "tif")},
    "entry.nc": {"entry": CloudEntry.read, "facts": CloudEntry.read_facts},
    "profile.csv": {"profile": lambda path: load_profile(str(path), Catalog())},
    "profile.nc": {"profile": lambda path: load_profile(str(path), Catalog())},
    "profiles.nc": {"profiles": lambda path: load_profiles(str(path), Catalog()).with_levels_near(36.0, 0.0)},
    "table.nc": {"table": AtmosphereTable.read},
    **{f"modtran.{suffix}": {"paths": read_paths} for suffix in ("json", "csv", "tp7")},
    "libradtran": {"paths": lambda path: read_paths(path / "a.out")},
    "response.csv": {
        "columns": read_columns,
        "response": lambda path: read_response(path.name, Catalog(base=path.parent)),
    },
    "index.csv": {"index": lambda path: load_refractive_index(Catalog(), str(path))},
    "psf.txt": {"kernel": read_kernel},
    "raster.nc": {"raster": _raster},
    "raster.tif": {"raster": _raster},
    "scenario.json": {"scenario": Scenario.load},
    "sweep.toml": {"points": lambda path: points_of(Design.load(path))},
    "posterior.nc": {"posterior": read_posterior, "draws": PosteriorDraws.read},
    "optics.nc": {"table": lambda path: read_into(optics_table(), path)},
}
"""Readers that take some milliseconds."""

SLOW = {
    "cube.nc": _CUBE,
    "measured.nc": {name: read for name, read in _CUBE.items() if name != "sense"},
    "cube.zarr": {name: _CUBE[name] for name in ("open", "export", "verify", "columns")},
    "scene": {"plan": lambda path: make_plan(Scenario.load(path / "scene.toml"))},
    "sweep": {"resume": _resume},
    "sweep.nc": {"open": lambda path: open_sweep(path).close()},
    "propagation.nc": {"open": lambda path: open_propagation(path).close()},
    "fit.state": {"fit": _fit_on},
    "cache": {"run": _with_what_was_kept},
}
"""Readers that take some hundredths to tenths of a second."""

PAGES = {
    name: {"report": _report}
    for name in ("cube.nc", "measured.nc", "cube.zarr", "sweep", "sweep.nc", "propagation.nc", "posterior.nc")
}
"""Readers that draw many figures: seconds."""

READERS = {"fast": FAST, "slow": SLOW, "pages": PAGES}
