"""Keys of sensor, platform and camera that state one quantity: agreement is accepted, contradiction refused by name.

Scenarios (``geometry_inputs.py``) were made before the readers were tried; what
keys imply is computed there from triangles and Kepler's third law.
"""

import json
from types import SimpleNamespace

import geometry_inputs
import pytest
from hcss_payload import Camera
from hcss_payload.build import payload_of
from hcss_payload.live.sensor import LiveSensor

import hcss_twin
from hcss_twin.core.catalog import Catalog
from hcss_twin.plan.sensor import make_sensor
from hcss_twin.plan.sensor_stages import Stage
from hcss_twin.providers import Grid, SensorInputs
from hcss_twin.scenario.bands import sensor_bands, spectral_band
from hcss_twin.scenario.viewing import viewing_notes


def examined(raw):
    """What is doubtful about the geometry of a scenario; raises what is wrong."""
    scenario = hcss_twin.Scenario.from_dict(raw)
    catalog = Catalog()
    if "camera" in scenario.sections:
        payload_of(scenario, catalog)
    notes = viewing_notes(scenario)
    if scenario.sensor is None:
        return notes
    bands = [spectral_band(band, catalog) for band in scenario.bands]
    inputs = SensorInputs(sensor_bands(bands), Grid(8, 8, scenario.image.pixel_size), 0.0, 1.0, 1, catalog)
    return *notes, *Stage.examine_geometry(json.loads(scenario.to_json()), make_sensor(scenario.sensor, inputs).stages)


def test_keys_that_agree_are_accepted():
    for given in geometry_inputs.good()[:17]:  # each kind
        assert examined(given.scenario) == (), given.name


def test_keys_that_contradict_each_other_are_refused_or_noted_by_name():
    for given in geometry_inputs.bad()[17:51]:
        try:
            told = "\n".join(examined(given.scenario))
        except hcss_twin.ScenarioError as error:
            told = str(error)
        missing = [name for name in given.names if not any(word in told for word in name.split("|"))]
        # Values that no instrument has are out of range of their own key; between the width of a footprint and the
        # square root of its solid angle a pixel at zenith 60 degrees may have any size.
        accepted = "zenith, pixel angle, factor 0.8" in given.name
        assert not missing or "is out of range" in told or accepted, (given.name, told)


def test_electrons_follow_from_the_same_angle_as_the_image():
    # 40 m from 500 km are 80 urad: a pixel angle of 40 urad would count a quarter of the electrons.
    scene = geometry_inputs.merged(
        geometry_inputs.SCENE,
        {"image": {"pixel_size": 40.0}, "platform": {"altitude": 5e5}},
        geometry_inputs.sensor(pixel_angle=4e-5),
    )
    with pytest.raises(
        hcss_twin.ScenarioError, match=r"pixel_angle: 4e-05 rad, and image\.pixel_size 40 m .* 8e-05 rad"
    ):
        hcss_twin.make_plan(hcss_twin.Scenario.from_dict(scene))


def test_a_live_camera_and_its_sensor_have_one_pixel_angle():
    scenario = hcss_twin.Scenario.from_dict(geometry_inputs.merged(geometry_inputs.SCENE, geometry_inputs.sensor()))
    bands = [spectral_band(band, Catalog()) for band in scenario.bands]
    assembly = SimpleNamespace(motion=SimpleNamespace(frame_interval_s=1.0))
    plan = SimpleNamespace(scenario=scenario, catalog=Catalog(), bands=bands, assembly=assembly)
    LiveSensor(plan, Camera(8, 8, 0.5, 2e-5))
    with pytest.raises(
        hcss_twin.ScenarioError, match=r"4e-05 rad, and camera\.detector_pitch 4e-05 m with camera\.focal"
    ):
        LiveSensor(plan, Camera(8, 8, 0.5, 4e-5))
