"""An instrument in orbit: the images of its camera, the jitter of its poses, the noise of its sensor."""

import json

import numpy as np
import pytest
from camera_scenes import CHEAP, LWIR, PASS, merged, scenario
from hcss_payload.build import payload_of

import hcss_twin
from hcss_twin.core.errors import ScenarioError
from hcss_twin.providers import Catalog

INSTRUMENT = {
    "rows": 40,
    "columns": 48,
    "f_number": 2.5,
    "aperture_diameter": "60 mm",
    "detector_pitch": "15 um",
    "bands": [LWIR],
    "nedt": "50 mK at 290 K",
    "saturation_temperature": "330 K",
    "bits": 14,
}
SKY = {"clouds": {"type": "paper-stratus", "coverage": 0.0}, "output": {"certificate": 0, "variables": ["radiance"]}}
IN_ORBIT = {key: value for key, value in PASS.items() if key != "camera"}


def test_an_instrument_has_the_camera_of_its_focal_length():
    of_instrument = payload_of(scenario(IN_ORBIT, {"instrument": INSTRUMENT | {"jitter": "0.3 px"}}), Catalog())
    of_camera = payload_of(scenario(PASS, {"jitter": {"rms": ["30 urad", "30 urad", 0.0]}}), Catalog())
    assert of_instrument.camera == of_camera.camera
    assert of_instrument.jitter.rms_rad == pytest.approx(of_camera.jitter.rms_rad)


def test_further_keys_of_the_camera_stay_and_other_values_are_refused():
    found = payload_of(scenario(IN_ORBIT, {"instrument": INSTRUMENT, "camera": {"beyond": "missing"}}), Catalog())
    assert found.beyond == "missing"
    with pytest.raises(ScenarioError, match=r"camera.rows: 41 with instrument.rows, which means 40; allowed: one"):
        scenario(IN_ORBIT, {"instrument": INSTRUMENT, "camera": {"rows": 41}})
    with pytest.raises(ScenarioError, match=r"jitter.rms: .* with instrument.jitter"):
        scenario(IN_ORBIT, {"instrument": INSTRUMENT | {"jitter": 0.3}, "jitter": {"rms": [0.1, 0.1, 0.0]}})
    with pytest.raises(ScenarioError, match=r"instrument.focal_length: is missing, .* 30 m from 500 km are .60 urad."):
        scenario(IN_ORBIT, {"instrument": {"f_number": 2, "rows": 40, "columns": 48}})


def test_the_measured_cube_of_an_instrument_in_orbit_has_its_noise_and_constants(tmp_path):
    raw = merged(IN_ORBIT, SKY, CHEAP, {"sensor": {"variables": ["all"]}, "instrument": INSTRUMENT})
    one = scenario(raw, {"frames": {"count": 1}})
    hcss_twin.simulate(one, tmp_path / "clean.nc").close()
    with hcss_twin.open_cube(tmp_path / "clean.nc") as clean, hcss_twin.open_cube(tmp_path / "clean.sensor.nc") as seen:
        constants = json.loads(seen.attrs["hcss_sensor"])["worked_out"]["bands"]["lwir"]
        back = constants["radiance_per_number"] * seen.digital_number + constants["radiance_at_number_0"]
        noise = np.hypot(constants["noise_radiance"], constants["radiance_per_number"] / np.sqrt(12.0))
        assert float(np.std(back - clean.radiance)) == pytest.approx(noise, rel=0.06)
        assert "instrument" not in json.loads(clean.attrs["hcss_scenario"])
