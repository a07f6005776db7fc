"""Small files of every kind that the package reads."""

import json
import os
import sys
from pathlib import Path

import netCDF4
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[2] / "plugins" / "hcss-modtran" / "tests"))

from cheap import CHEAP
from hcss_evaluate.database.cloud_import import ImportOptions, import_image
from hcss_evaluate.errors import PosteriorError
from hcss_evaluate.matching.target import ImageChoice
from hcss_evaluate.posterior.fit import fit
from hcss_sweep.run import sweep
from hcss_uncertainty.propagation import propagate
from posterior_example import example_posterior
from surface_files import write_netcdf
from tape7_text import radiance_run
from tape7_text import write as write_tape7

from hcss_twin.core.catalog import Catalog
from hcss_twin.engine.sense import sense_file
from hcss_twin.engine.simulate import run
from hcss_twin.models.atmosphere.table_file import DIMENSIONS, FORMAT, FORMAT_VERSION
from hcss_twin.models.optics import table_store
from hcss_twin.models.optics.bulk import Accuracy, BulkTable
from hcss_twin.models.optics.size_distribution import gamma_distribution
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.physics.planck import planck
from hcss_twin.plan.make_plan import make_plan
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
SENSOR = SensorSection.model_validate({"parameters": {"noise": "nedt", "nedt": 0.05}})
SWEPT = {"sea.temperature": [290.0, 291.0]}
FIT = {
    "choice": ImageChoice(pixel_size_m=100.0),
    "seed": 1,
    "most_steps": 500,
    "fixed": {"gamma": 3.0},
    "octaves": (0, 4),
}
WAVENUMBER = np.arange(800.0, 820.5, 5.0)

SCENE = """title = "x"
time = "2024-04-20T12:30:00Z"
seed = 3
bands = ["lwir", {name = "mine", response = "response.csv"}]
[image]
rows = 8
columns = 8
[frames]
count = 1
[place]
latitude = 35.1
longitude = 150.0
[view]
zenith = 20
[clouds]
type = "cloud.toml"
coverage = 0.4
[sea]
model = "cox-munk"
wind_speed = 5
[optics]
provider = "mie"
[radiance]
model = "as-printed"
[atmosphere]
profile = "profile.csv"
[sensor]
parameters = {psf = "file", psf_file = "psf.txt"}
"""


def small_stratus(**changes):
    """The shipped stratus, smaller and with the cheapest models."""
    return Scenario.from_dict(json.loads(Scenario.load("stratus").to_json()), SMALL | changes)


def make_files(folder, runs=True):
    """Write one file, or one folder, of each kind and return them by name; ``runs``: those of commands that compute."""
    folder.mkdir(parents=True, exist_ok=True)
    for write in (_images, write_airs, _texts, _rasters, _scene, _optics, *((_results, _kept) if runs else ())):
        write(folder)
    return {path.name: path for path in sorted(folder.iterdir())}


def noise():
    """Return the image of all files of images: 40 x 40 random grey levels."""
    return np.random.default_rng(1).integers(0, 255, (40, 40)).astype(np.uint8)


def _images(folder):
    from PIL import Image as Picture

    values = noise()
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
    import_image(folder / "image.npy", ImportOptions(pixel_size_m=100.0)).write(folder / "entry.nc")


def write_airs(folder):
    """Write profiles, tables and outputs of radiation codes."""
    (folder / "profile.csv").write_bytes((Catalog().root / "atmospheres" / "us-standard-1976.csv").read_bytes())
    _profiles(folder / "profile.nc", [35.0])
    _profiles(folder / "profiles.nc", [30.0, 35.0, 40.0])
    small_table(folder / "table.nc")
    write_tape7(folder / "modtran.tp7", radiance_run(WAVENUMBER))
    (folder / "modtran.json").write_text(modtran6())
    rows = [",".join(f"{value:.7E}" for value in row) for row in zip(*_spectra().values(), strict=True)]
    head = ["MODTRAN6", "freq,total transmittance,path emission,total radiance", "(cm-1),,(W cm-2 sr-1/cm-1)"]
    (folder / "modtran.csv").write_text("\n".join([*head, *rows, "-9999."]))
    (folder / "libradtran").mkdir(exist_ok=True)
    beam = [f"{1e7 / number:.9e} 0.25 0.5" for number in WAVENUMBER[::-1]]
    (folder / "libradtran" / "a.out").write_text("\n".join(beam))
    (folder / "libradtran" / "a.inp").write_text(
        "source solar\noutput_quantity transmittance\nsza 60\noutput_user lambda edir eglo\n"
    )


def _spectra():
    tau = np.full(WAVENUMBER.size, 0.5)
    emission = 0.5 * planck(WAVENUMBER, 250.0) * 1e-4
    return {"FREQ": WAVENUMBER, "TOT_TRANS": tau, "PTH_THRML": emission, "TOTAL_RAD": emission}


def modtran6():
    """A case of MODTRAN 6: half-transparent air of 250 K above nothing."""
    geometry = {"H1ALT": 0.0, "H2ALT": 100.0, "OBSZEN": 60.0, "ITYPE": 3}
    inputs = {"GEOMETRY": geometry, "SPECTRAL": {"XFLAG": "W", "FWHM": 5.0}, "ATMOSPHERE": {"MODEL": "ATM_US_STD_1976"}}
    spectra = {name: values.tolist() for name, values in _spectra().items()}
    case = {"MODTRANINPUT": inputs, "MODTRANOUTPUT": {"SPECTRA": {"RADIANCE": spectra}}}
    return json.dumps({"MODTRAN": [case]}, indent=1)


_KELVIN, _VAPOUR = [288, 280, 250, 230, 217, 210], [1e-2, 5e-3, 1e-3, 1e-4, 5e-6, 4e-6]


def _profiles(path, latitude):
    """Pressure levels at latitudes, as in a reanalysis."""
    pressure = np.array([101300.0, 85000.0, 50000.0, 30000.0, 20000.0, 10000.0])
    with netCDF4.Dataset(path, "w") as file:
        for name, values, units in (("pressure_level", pressure, "Pa"), ("latitude", latitude, "degrees_north")):
            file.createDimension(name, len(values))
            axis = file.createVariable(name, "f8", (name,))
            axis.units, axis[:] = units, values
        dimensions = ("pressure_level", "latitude")[: min(len(latitude), 2)]
        for name, units, levels in (("t", "K", _KELVIN), ("h2o", "1", _VAPOUR)):
            variable = file.createVariable(name, "f8", dimensions)
            variable.units = units
            variable[:] = np.reshape(np.outer(levels, np.ones(len(latitude))), variable.shape)


def small_table(path, **changed):
    """An atmosphere table of 3 heights, 2 angles and 5 wavenumbers."""
    values = {
        "target_altitude_m": np.array([0.0, 1000.0, 5000.0]),
        "zenith_deg": np.array([0.0, 60.0]),
        "wavenumber_cm1": np.linspace(900.0, 1000.0, 5),
        "transmittance": np.full((3, 2, 5), 0.5),
        "path_radiance": np.full((3, 2, 5), 0.01),
        "level_altitude_m": np.array([0.0, 5000.0, 1e5]),
        "level_pressure_Pa": np.array([1e5, 5e4, 1.0]),
        "level_temperature_K": np.array([290.0, 260.0, 200.0]),
    } | changed
    with netCDF4.Dataset(path, "w") as file:
        file.format, file.format_version, file.source = FORMAT, FORMAT_VERSION, "made up"
        for name in (*DIMENSIONS, "level"):
            file.createDimension(name, len(values.get(name, values["level_altitude_m"])))
        for name, array in values.items():
            dims = DIMENSIONS if array.ndim == 3 else (name if name in DIMENSIONS else "level",)
            file.createVariable(name, "f8", dims)[:] = array
    return path


def _texts(folder):
    (folder / "response.csv").write_text("wavelength_um,response\n10,0\n10.5,1\n11,0.5\n12,0\n")
    (folder / "index.csv").write_text("wavelength_um,n,k\n0.5,1.33,1e-9\n3,1.4,0.2\n20,1.3,0.1\n")
    (folder / "psf.txt").write_text("0.1 0.2 0.1\n0.2 1.0 0.3\n0.0 0.2 0.1\n")
    example_posterior(folder / "posterior.nc")
    (folder / "scenario.json").write_text(Scenario.load("cirrus").to_json())
    swept = "[sweep]\nsea.temperature = {from = 280, to = 290, steps = 3}\nview.zenith = [0, 30]\n"
    shipped = (Catalog().root / "scenarios" / "stratus.toml").read_text(encoding="utf-8")
    (folder / "sweep.toml").write_text(f"{shipped}\n{swept}")


def _rasters(folder):
    import rasterio

    latitude, longitude = np.linspace(34.5, 35.5, 30), np.linspace(149.5, 150.5, 30)
    write_netcdf(folder / "raster.nc", latitude, longitude, surface_class=np.tile(longitude > 150.0, (30, 1)))
    place = rasterio.Affine(1 / 40, 0.0, 149.5, 0.0, -1 / 40, 35.5)
    about = {"driver": "GTiff", "height": 40, "width": 40, "count": 1, "dtype": "uint8", "crs": "EPSG:4326"}
    with rasterio.open(folder / "raster.tif", "w", **about, transform=place) as file:
        file.write(np.tile(np.arange(40) > 20, (40, 1)).astype(np.uint8), 1)


def _scene(folder):
    scene = folder / "scene"
    scene.mkdir(exist_ok=True)
    for name in ("response.csv", "profile.csv", "psf.txt"):
        (scene / name).write_bytes((folder / name).read_bytes())
    (scene / "cloud.toml").write_bytes((Catalog().root / "cloud_types" / "stratus.toml").read_bytes())
    (scene / "scene.toml").write_text(SCENE)


def _results(folder):
    """Write what commands write and others read: cubes, sweeps, propagations, the state of a fit."""
    scenario = small_stratus()
    for name in ("cube.nc", "cube.zarr"):
        run(make_plan(scenario), folder / name)
    sense_file(folder / "cube.nc", SENSOR, folder / "measured.nc")
    sweep(scenario, folder / "sweep", over=SWEPT, dataset=folder / "sweep.nc")
    propagate(scenario, folder / "propagation.nc", draws=3, uncertain={"sea.temperature": "normal:291:0.5"})
    try:
        fit(folder / "image.npy", folder / "fit.nc", **FIT)
    except PosteriorError:  # too few steps: what stays is the state
        (folder / "fit.nc.state").rename(folder / "fit.state")


def optics_table():
    """An empty table of droplets, so small that it takes no time."""
    cloud = gamma_distribution("water", 5.0, 0.1, 1e-4)
    index = load_refractive_index(Catalog(), "water")
    return BulkTable(cloud, index, Accuracy(radius_nodes=50, spectral_step=0.05, moments=16))


def _optics(folder):
    table = optics_table()
    table.complete(np.log(np.linspace(10.0, 11.0, 9)), lambda pieces, _: pieces)
    table_store.write(table, folder / "optics.nc")


def _kept(folder):
    """Write what runs keep for later runs."""
    before = os.environ.get("HCSS_CACHE_DIR")
    os.environ["HCSS_CACHE_DIR"] = str(folder / "cache")
    try:
        run(make_plan(small_stratus()), folder / "cube.nc")
    finally:
        del os.environ["HCSS_CACHE_DIR"]
        if before is not None:
            os.environ["HCSS_CACHE_DIR"] = before
