"""Kernels that the first run of a scene compiles, most of them in copies of its process while the plan is made.

They are named with the types of their arguments, so that they can be compiled before anything is computed.
"""

from __future__ import annotations

from hcss_twin.core.kernels import Ahead
from hcss_twin.cube.variables import SHADOW_MASK, VARIABLES
from hcss_twin.plan.lines_of_sight import SunTrack
from hcss_twin.scenario.scenario import Scenario

FRACTAL = "fractal", "hcss-twin/fractal"

_BLOCKS = "i8[::1], i8[::1], i8[::1]"
_NODES = "f4[:,::1], f4[:,::1], i4[:,:,::1], u8[::1], f4[::1], i8[::1], i8[::1]"
_GATHERED = "f4[:,::1], i8[::1], u4[::1], f4[:,::1], b1"
OF_FRACTAL = (
    Ahead("hcss_twin.models.clouds.fractal.blocks", "_fill_blocks", f"u8[::1], {_BLOCKS}, f4[:,::1]", 1.5),
    Ahead("hcss_twin.models.clouds.fractal.rows", "add_octave", f"{_NODES}, {_GATHERED}", 3.2),
    Ahead("hcss_twin.models.clouds.thickness", "_map_field", "f4[::1], f4, f4, f4, f4, f4, f4, f4, f8", 0.9),
)

_STARTS = "Tuple((f8[:,:,::1], f8[:,:,::1], f8[::1], i8[::1]))"
_ARRAYS = "UniTuple(f8[::1], 2), UniTuple(i8[::1], 4), UniTuple(i8, 2), UniTuple(f8[:,:,::1], 3)"
OF_CLOUDS = Ahead("hcss_twin.physics.multiple_scattering.doubling", "solve_chains", f"{_STARTS}, {_ARRAYS}", 4.0)

_LAYER = "Tuple((f4[:,::1], i4[:,::1], f8[::1], i4[::1], i8, i8))"
_POINTS = Ahead("hcss_twin.engine.tables.look_up", "_points", f"f4[:,:,::1], i8, i8, f8[:,::1], {_LAYER}", 0.8)
_PIXELS = Ahead("hcss_twin.engine.tables.look_up", "_one_layer", f"f4[:,:,::1], i8, i8, i8, f8[:,::1], {_LAYER}", 0.8)

_READ_ONLY = "Array(f4, 2, 'C', True)"
_STATES = "f4[:,::1], i8[:,::1], f4[::1], f8[::1], f8[:,::1]"
OF_TEXTURE = (
    Ahead("hcss_twin.models.sea.texture", "_add_interpolated", "f4[:,::1], f4[:,::1], i8, i8, f4[:,::1]", 0.6),
    Ahead(
        "hcss_twin.engine.stages.texture",
        "_apply",
        f"f4[:,:,::1], i8, i8, f4[:,:,:,::1], b1, {_READ_ONLY}, {_READ_ONLY}, {_STATES}",
        1.5,
    ),
)

_SLICES = "f4[:,::1], f4[:,::1], Array(i8, 2, 'F'), f8[::1], f8"
_CAST = "f4[:,:,::1], u1[:,::1], f4[:,:,::1], i8, i8, i8, b1[:,::1], f4[:,:,::1]"
_BY_PATH = "Tuple((f8[::1], f4[:,:,:,::1], f8[:,:,::1]))"
_BY_TEXTURE = f"Tuple((f8[:,:,:,::1], f8[:,:,::1], {_READ_ONLY}))"
OF_SHADOWS = (
    Ahead("hcss_twin.engine.stages.shadows", "_add_slices", _SLICES, 1.2),
    Ahead("hcss_twin.engine.stages.shadows", "_cast", f"{_CAST}, {_BY_PATH}, {_BY_TEXTURE}, f8[:,:,::1]", 3.7),
)

_TABLES = "f4[:,:,::1], f4[:,:,:,::1], f8[:,:,::1], f4[:,:,::1], f8[:,:,:,::1]"
OF_WAVES = (
    Ahead("hcss_twin.models.sea.plane_waves", "_spread", "f4[:,::1], i8[::1], f4[:,::1], f4[:,::1], f4[:,::1]", 0.5),
    Ahead("hcss_twin.models.sea.plane_waves", "_store", "f4[:,:,::1], c8[:,::1], f4[::1], i8, i8", 0.3),
    Ahead("hcss_twin.engine.stages.waves", "_add", f"{_TABLES}, f4[:,::1], f4[:,:,::1], b1[:,::1], i8", 3.2),
)


def kernels_of(scenario: Scenario) -> list[Ahead]:
    """Return the kernels of a scene with the models of this package, in the order in which they are needed.

    What the plan leaves out may be among them.
    """
    names = {*scenario.output.variables}
    of_truth = {spec.name for spec in VARIABLES if not spec.needs_radiance}
    place, sea = scenario.place, scenario.sea
    first_s = float(scenario.frames.first) * float(scenario.frames.interval)
    is_day = SunTrack(scenario.time, place.latitude, place.longitude).at(first_s).is_up
    layers = len(scenario.clouds.layers)
    found = [*OF_FRACTAL] if any(layer.generator in FRACTAL for layer in scenario.clouds.layers) else []
    if not names <= of_truth:
        found += [OF_CLOUDS] * (layers > 0)
        found += [_POINTS if scenario.image.samples_per_pixel == 1 else _PIXELS] * (layers == 1)
        if (sea.temperature_texture, scenario.atmosphere.water_vapour_texture) != (0.0, 0.0):
            found += OF_TEXTURE
    if is_day and layers and scenario.slant.shadows != "off" and names - (of_truth - {SHADOW_MASK}):
        found += OF_SHADOWS
    if is_day and sea.waves != "off" and not names <= of_truth:
        found += OF_WAVES
    return found
