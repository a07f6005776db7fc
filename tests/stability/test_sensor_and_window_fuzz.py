"""Any sensor on any platform measures a sound cube or is refused; any window is that part of the image to the bit."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scenario_space import PHYSICAL, scenarios, seen_scenarios, window_of, write_files

from hcss_twin import HcssError, Scenario, make_plan, open_cube
from hcss_twin.engine.simulate import run


def _settings(examples):
    return settings(
        max_examples=examples,
        deadline=None,
        derandomize=True,
        database=None,
        suppress_health_check=list(HealthCheck),
        print_blob=False,
    )


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return write_files(tmp_path_factory.mktemp("files"))


def cubes(raw, base):
    """Clean and measured cube of a scenario, or None and the error on purpose that it ends in."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "c.nc"
        try:
            run(
                make_plan(
                    Scenario.from_dict({**raw, "output": {**raw.get("output", {}), "certificate": 0}}, base=base)
                ),
                path,
            )
        except HcssError:
            # Clouds and surroundings have their own test; a clean cube may be there, half a measured one may not.
            refused = list(Path(folder).glob("*sensor.nc*"))
        else:
            refused = None
        if refused is not None:
            assert refused == []
            return None
        with open_cube(path) as clean:
            clean = clean.load()
        measured_path = path.with_suffix(".sensor.nc")
        if not measured_path.exists():
            return clean, None
        with open_cube(measured_path) as measured:
            return clean, measured.load()


def check_measured(raw, base):
    """Measure, and hold what comes against what a sensor can give; whether there is a cube."""
    made = cubes(raw, base)
    if made is None:
        return False
    clean, measured = made
    if "radiance" not in clean:
        return True
    radiance, chosen = measured["radiance"].values, raw["sensor"]["parameters"]
    assert radiance.shape == clean["radiance"].shape
    assert np.all(np.isfinite(radiance))
    if "digital_number" in measured:
        numbers = measured["digital_number"].values
        assert numbers.min() >= 0
        assert numbers.max() <= 2 ** chosen["bits"] - 1
    if "photon_rate" in measured:
        assert np.all(measured["photon_rate"].values >= 0)
        assert np.all(np.isfinite(measured["photon_rate"].values))
    noisy = chosen["noise"] != "none" or chosen.get("gain_deviation") or "saturation_radiance" in chosen
    if chosen["psf"] == "none" and not noisy:
        np.testing.assert_array_equal(radiance, clean["radiance"].values)
    again = cubes(raw, base)
    np.testing.assert_array_equal(again[1]["radiance"].values, radiance)
    return True


@st.composite
def windowed(draw, drawn):
    raw = draw(drawn)
    return raw, window_of(draw, raw["image"])


def check_window(raw, window, base):
    """A window's cubes are that part of the whole's; whether there are any."""
    whole = cubes(raw, base)
    part = cubes({**raw, "image": {**raw["image"], "window": window}}, base)
    if whole is None or part is None:
        return False
    place = {"y": slice(*window["rows"]), "x": slice(*window["columns"])}
    for one, other in zip(whole, part, strict=True):
        assert (one is None) is (other is None)
        if one is None:
            continue
        assert set(one.data_vars) == set(other.data_vars)
        for name in one.data_vars:
            mine = one[name].isel({key: each for key, each in place.items() if key in one[name].dims})
            np.testing.assert_array_equal(mine.values, other[name].values, err_msg=name)
    return True


class TestAnySensorOnAnyPlatformMeasuresASoundCubeOrIsRefused:
    def test_few(self, files):
        measured = []

        @_settings(9)
        @given(seen_scenarios())
        def measure(raw):
            measured.append(check_measured(raw, files))

        measure()
        # Otherwise refusals only would be tested.
        assert np.mean(measured) > 0.3

    @pytest.mark.campaign
    @_settings(25)
    @given(raw=seen_scenarios())
    def test_many(self, raw, files):
        check_measured(raw, files)

    @pytest.mark.campaign
    @_settings(3)
    @given(raw=seen_scenarios(PHYSICAL))
    def test_many_of_the_default_models(self, raw, files):
        check_measured(raw, files)


class TestAnyWindowIsThatPartOfTheImageToTheBit:
    @_settings(6)
    @given(drawn=windowed(scenarios()))
    def test_few(self, drawn, files):
        check_window(*drawn, files)

    @pytest.mark.campaign
    @_settings(15)
    @given(drawn=windowed(seen_scenarios()))
    def test_many_measured(self, drawn, files):
        check_window(*drawn, files)
