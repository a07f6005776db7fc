"""Frames and labels against closed forms and against ``hcss run`` of the same draw."""

import json

import numpy as np
import pytest
from hcss_dataset.distribution import Distribution
from hcss_dataset.rendering import Studio
from sets import BANDS, CLEAR, NEDT_K, NOISELESS, SIGMA, centre, keys, spot

from hcss_twin import Scenario, make_plan, open_cube, simulate
from hcss_twin.providers import planck


def sequences(given, count):
    studio = Studio(Distribution.load(given))
    return [studio.sequence(number) for number in range(count)]


def added(frame):
    """What targets add to the image, in numbers of the converter of a sensor without noise."""
    return frame.image.astype(float) - frame.clean.astype(float)


STRONG = {"intensity": 1e4, "by_band": {"mwir": 0.01, "lwir": 1.0}}
"""Thousands of steps of the converter in both bands."""

STILL = {"count": 1, "margin": 12, "altitude": 5000.0, "strength": STRONG}


def test_plumes_are_point_images_at_their_places_with_the_flux_of_their_intensity():
    for sequence in sequences(keys({**CLEAR, **NOISELESS}, targets=STILL), 3):
        frame = next(sequence.frames())
        (target,), step = frame.labels["targets"], np.array(frame.labels["radiance_per_number"])
        row, column = target["centroid"]
        first = int(row) - 9, int(column) - 9
        near = np.s_[first[0] : first[0] + 19, first[1] : first[1] + 19]
        for band in range(2):
            image = added(frame)[band][near] * step[band]
            expected = spot((19, 19), row - first[0], column - first[1])
            light = target["intensity_W_sr"][band] * target["transmittance"][band] / 20.0**2
            assert target["flux"][band] == pytest.approx(light, rel=1e-3)
            assert image.sum() == pytest.approx(light, rel=1e-3)
            assert target["peak"][band] == pytest.approx(light * expected.max(), rel=1e-2)
            assert np.hypot(*np.subtract(centre(image), np.subtract((row, column), first))) < 0.01
        assert target["visible"] == [1.0, 1.0]
        assert target["centroid"] == pytest.approx(target["place"], abs=1e-9)


def test_masks_and_boxes_are_the_pixels_above_the_share_of_the_peak():
    given = keys({**CLEAR, **NOISELESS}, targets=STILL, labels={"mask_share": 0.2})
    for sequence in sequences(given, 3):
        frame = next(sequence.frames())
        (target,) = frame.labels["targets"]
        expected = spot(frame.image.shape[1:], *target["centroid"])
        above = expected >= 0.2 * expected.max()
        runs = target["mask"]["counts"]
        mask = np.repeat(np.arange(len(runs)) % 2 == 1, runs).reshape(40, 48).T
        assert np.array_equal(mask, above)
        rows, columns = np.nonzero(above)
        assert target["box"] == [columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1]


def test_moving_targets_smear_by_their_motion():
    moving = STILL | {"speed": 1200.0, "heading": 30.0}
    changes = {**CLEAR, **NOISELESS, "frames.count": 1, "sensor.parameters": None}
    changes["sensor.parameters"] = {"psf": "gaussian", "psf_sigma": SIGMA, "integration_time": 0.1}
    for sequence in sequences(keys(changes, targets=moving), 3):
        frame = next(sequence.frames())
        (target,) = frame.labels["targets"]
        rates = target["pixels_per_s"]
        assert rates == pytest.approx([60.0 * np.cos(np.pi / 6), 60.0 * np.sin(np.pi / 6)], rel=1e-6)
        expected = spot(frame.image.shape[1:], *target["centroid"], motion=np.multiply(rates, 0.1))
        assert target["peak"][0] == pytest.approx(target["flux"][0] * expected.max(), rel=1e-2)


def test_targets_move_along_their_velocity():
    moving = STILL | {"speed": 100.0}
    for sequence in sequences(keys({**CLEAR, **NOISELESS}, targets=moving), 3):
        first, second = (frame.labels["targets"][0] for frame in sequence.frames())
        east, north, _ = first["velocity_m_s"]
        moved = np.subtract(second["centroid"], first["centroid"])
        assert moved == pytest.approx([north * 0.5 / 20.0, east * 0.5 / 20.0], abs=1e-9)
        assert first["track"] == second["track"] == 1


def test_noise_and_snr_are_those_of_the_sensor():
    (sequence,) = sequences(keys({**CLEAR, "image.rows": 200, "image.columns": 200}, targets=STILL), 1)
    frame = next(sequence.frames())
    (target,) = frame.labels["targets"]
    for band, about in enumerate(BANDS):
        um = np.linspace(*about["limits"], 201)
        of_kelvin = [np.trapezoid(planck(1e4 / um[::-1], kelvin), 1e4 / um[::-1]) for kelvin in (299.5, 300.5)]
        noise = NEDT_K * (of_kelvin[1] - of_kelvin[0])
        assert frame.labels["noise"][band] == pytest.approx(noise, rel=1e-3)
        assert target["snr"][band] == pytest.approx(target["peak"][band] / noise, rel=0.01)
        # The sea is even: all there is around the target is noise.
        assert target["scr"][band] == pytest.approx(target["snr"][band], rel=0.01)


ELECTRONS = {"noise": "photon", "aperture_diameter": 0.2, "pixel_angle": 40e-6, "integration_time": 1e-3}
SENSORS = {
    "nedt": {"noise": "nedt", "nedt": 0.05},
    "electrons": ELECTRONS | {"transmission": 0.8, "quantum_efficiency": 0.6, "read_noise": 300.0, "dark_current": 1e8},
    "pattern": {
        "noise": "nedt",
        "nedt": 0.02,
        "gain_deviation": 0.002,
        "offset_radiance": {"mwir": 0.002, "lwir": 0.02},
    },
    "converter": {"noise": "nedt", "nedt": 0.05, "bits": 12, "saturation_temperature": 320.0},
}


@pytest.mark.parametrize("name", SENSORS)
def test_the_noise_is_that_of_the_pixels_of_many_frames(name):
    parameters = SENSORS[name] | {"psf": "gaussian", "psf_sigma": SIGMA}
    size = {"image.rows": 160, "image.columns": 160, "frames.count": 2, "sensor.parameters": parameters}
    sequence = next(iter(sequences(keys(size, targets={}), 1)))
    step = sequence.scale.step[:, None, None]
    for frame in sequence.frames():
        clean = frame.clean.astype(float)  # rounded, too, which adds a twelfth of a squared step
        square = np.mean((step * (frame.image - clean)) ** 2, axis=(1, 2)) - step[:, 0, 0] ** 2 / 12.0
        # 25 600 pixels: .44 % for one standard deviation
        assert np.sqrt(square) == pytest.approx(np.array(frame.labels["noise"]), rel=0.015)


def test_targets_have_the_wanted_scr_in_the_first_frame():
    wanted = keys()["targets"] | {"count": 3, "strength": {"scr": 7.0}}
    for sequence in sequences(keys(targets=wanted), 2):
        frame = next(sequence.frames())
        assert len(frame.labels["targets"]) == 3
        for target in frame.labels["targets"]:
            assert target["scr"][0] == pytest.approx(7.0, rel=1e-5)
            row, column = (int(at) for at in target["place"])
            near = np.s_[max(row - 15, 0) : row + 16, max(column - 15, 0) : column + 16]
            clean = frame.clean[0][near] * frame.labels["radiance_per_number"][0]
            assert target["clutter"][0] == pytest.approx(clean.std(), rel=1e-3, abs=1e-5)


def test_the_hidden_share_of_a_body_is_that_of_its_points_under_cloud():
    body = {"count": 1, "margin": 6, "altitude": 0.0, "strength": {"temperature": 320.0, "area": (7 * 20.0) ** 2}}
    cloud = {"type": "stratus", "coverage": 0.5, "coverage_mode": "field", "base": 900.0, "top": 1300.0}
    changes = {"clouds": {**cloud, "thickness_min": 300.0}, "frames.count": 1, **NOISELESS}
    shares = []
    for sequence in sequences(keys(changes, targets=body), 6):
        frame = next(sequence.frames())
        (target,) = frame.labels["targets"]
        plan = make_plan(sequence.scenario)
        rows, columns = (np.arange(size) for size in frame.image.shape[1:])
        (generator,) = plan.assembly.generators
        thickness = generator.thickness_m(0.0, slice(0, 48), slice(0, 40))
        row, column = target["place"]
        half = 3.5
        down = np.clip(np.minimum(rows + 1, row + half) - np.maximum(rows, row - half), 0.0, 1.0)
        across = np.clip(np.minimum(columns + 1, column + half) - np.maximum(columns, column - half), 0.0, 1.0)
        weights = np.outer(down, across)
        clear = weights[thickness == 0.0].sum() / weights.sum()
        assert target["visible"][1] == pytest.approx(clear, abs=0.01)
        shares.append(clear)
    assert min(shares) < 0.9
    assert max(shares) > 0.1


@pytest.mark.parametrize("sensor", [True, False], ids=["sensor", "no sensor"])
def test_a_run_of_the_shown_draw_gives_the_same_frames(tmp_path, sensor):
    given = keys({} if sensor else {"sensor": None})
    sequence = next(each for each in sequences(given, 6) if len(each.targets) > 1)
    path = tmp_path / "draw.json"
    path.write_text(sequence.scenario.to_json())
    shown = Scenario.load(path)
    plain = json.loads(shown.to_json())
    del plain["elements"]
    simulate(shown, tmp_path / "draw.nc")
    with simulate(Scenario.from_dict(plain), tmp_path / "clean.nc") as clean:
        for index, frame in enumerate(sequence.frames()):
            radiance = clean["radiance"].isel(time=index).to_numpy()
            # the tables are those of the draw, and their stated error is that of both
            assert np.abs(sequence.clean_radiance(index) / radiance - 1.0).max() < 1e-6 < frame.labels["table_error"]
    with open_cube(tmp_path / ("draw.sensor.nc" if sensor else "draw.nc")) as cube:
        for index, frame in enumerate(sequence.frames()):
            numbers = sequence.scale.numbers(cube["radiance"].isel(time=index).to_numpy())
            assert np.abs(frame.image.astype(int) - numbers.astype(int)).max() <= 1


def test_numbers_of_a_converter_are_those_of_the_sensor():
    parameters = {"psf": "gaussian", "psf_sigma": SIGMA, "noise": "nedt", "nedt": NEDT_K, "bits": 12}
    parameters |= {"saturation_temperature": 310.0, "number_offset": 50}
    (sequence,) = sequences(keys({"sensor.parameters": parameters}, targets=STILL), 1)
    frame = next(sequence.frames())
    assert frame.labels["largest_number"] == 4095
    assert frame.image.max() <= 4095
    step, offset = (np.array(frame.labels[f"radiance_{name}"]) for name in ("per_number", "at_number_0"))
    difference = step[:, None, None] * (frame.image.astype(float) - frame.clean)
    rms = np.sqrt(np.mean(difference[:, :5] ** 2, axis=(1, 2)))  # no target is so close to the edge
    assert rms == pytest.approx(np.array(frame.labels["noise"]), rel=0.15)
    mean = offset + step * frame.clean.mean(axis=(1, 2))
    assert sequence.clean_radiance(0).mean(axis=(1, 2)) == pytest.approx(mean, rel=2e-3)
