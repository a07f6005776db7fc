"""Bad input gets a clear error: field as typed, value, what is allowed, closest valid choice; all at once."""

import json

import pytest
from refusals import problems_of

from hcss_twin import Scenario, ScenarioError, make_plan
from hcss_twin.core.catalog import catalog_root

TIME = "time = 2024-04-20T12:30:00+10:00\n"
PLACE = "place = {latitude = 35.0, longitude = 150.0}\n"
EXAMPLE = "2024-04-20T12:30:00+10:00"


def refusal(text, overrides=None, base=None):
    return problems_of(lambda: make_plan(Scenario.from_toml(text, overrides, base=base)))


WRONG = [
    # unknown keys, at every level
    ('cloud.type = "stratus"', "cloud", "unknown key", "closest is 'clouds'"),
    ("view.zenit = 3", "view.zenit", "allowed: azimuth, zenith", "closest is 'zenith'"),
    ("zenith = 3", "zenith", "closest is 'view.zenith'"),
    ("view.wind_speed = 3", "view.wind_speed", "closest is 'motion.wind_speed'"),
    ("clouds.coverag = 0.4", "clouds.coverag", "closest is 'coverage'"),
    ("clouds.parameters.h = 0.2", "clouds.parameters.h", "closest is 'H'"),
    ("atmosphere.parameters.fil = 'x'", "atmosphere.parameters.fil", "closest is 'file'"),
    ("[[clouds.layers]]\ncoverag = 0.4", "clouds.layers[0].coverag", "closest is 'coverage'"),
    ("[[clouds.layer]]\ntype = 'stratus'", "clouds", "closest is 'layers'"),
    ("bands = [{name = 'x', respons = 'y'}]", "bands[0].respons", "closest is 'response'"),
    ("coverage = 0.3", "coverage", "unknown key", "closest is 'clouds.coverage'"),
    ("view.coverage = 0.3", "view.coverage", "closest is 'clouds.coverage'"),
    ("temperature = 290", "temperature", "closest is 'clouds.temperature' or 'sea.temperature'"),
    # parameters that stand beside `parameters`
    ("clouds.gamma = 2", "clouds.gamma", "closest is 'clouds.parameters.gamma'", "cloud generator 'fractal'"),
    ("clouds.gama = 2", "clouds.gama", "closest is 'clouds.parameters.gamma'"),
    ("[[clouds.layers]]\ngamma = 2", "clouds.layers[0].gamma", "'clouds.layers[0].parameters.gamma'"),
    ("clouds.image = 'x'", "clouds.image", "'clouds.parameters.image'", 'with clouds.generator = "imagery"'),
    ("atmosphere.aerosol = 'none'", "atmosphere.aerosol", "closest is 'atmosphere.parameters.aerosol'"),
    ("atmosphere.visibility = 5", "atmosphere.visibility", "'atmosphere.parameters.visibility_km'"),
    ("sea.slopes = 'isotropic'", "sea.slopes", "closest is 'sea.parameters.slopes'"),
    ("optics.phase_function = 'mie'", "optics.phase_function", "'optics.parameters.phase_function'"),
    ("radiance.streams = 8", "radiance.streams", "closest is 'radiance.parameters.streams'"),
    ("sensor.pfs = 'airy'", "sensor.pfs", "closest is 'sensor.parameters.psf'"),
    ("sea.coverage = 0.3", "sea.coverage", "closest is 'clouds.coverage'"),
    ("sea.wind_sped = 3", "sea.wind_sped", "closest is 'wind_speed'"),
    ("sea.model = 'cox-munk'\nsea.slopes = 'x'", "sea.slopes", "'sea.parameters.slopes'", '= "rough-sea"'),
    ("clouds.seed = 3", "clouds.seed", "closest is 'seed' or 'sensor.seed'"),
    ("response = 'x.csv'", "response", "closest is 'bands[0].response'"),
    # ranges
    ("view.zenith = 95", "view.zenith", "95 is out of range", ">= 0 and <= 85", "choice is 85"),
    ("clouds.coverage = 1.3", "clouds.coverage", "1.3 is out of range", "choice is 1"),
    ("clouds.coverage = '130%'", "clouds.coverage", "'130%' = 1.3", "choice is 1"),
    ("clouds.parameters.H = 2", "clouds.parameters.H", "> 0 and < 1", "just below 1"),
    ("clouds.parameters.k = [1, 40]", "clouds.parameters.k[1]", ">= 0 and <= 16", "choice is 16"),
    ("clouds.parameters.k = [4, 1]", "clouds.parameters.k", "closest is [1, 4]"),
    ("clouds.base = '-1 m'", "clouds.base", "'-1 m' = -1", "choice is 0"),
    ("view.azimuth = -10", "view.azimuth", ">= 0 and < 360", "choice is 350"),
    ("motion.wind_from = '7 rad'", "motion.wind_from", "'7 rad' = 401.07", "choice is 41.07"),
    ("image.pixel_size = 0", "image.pixel_size", ">= 0.001 and <= 100000", "closest valid choice is 0.001"),
    ("image.rows = 199999", "image.rows", "choice is 100000"),
    ("seed = 9223372036854775808", "seed", "choice is 9223372036854775807"),
    ("clouds.coverage = 30", "clouds.coverage", ">= 0 and <= 1", "choice is 0.3, which is 30 %"),
    ("clouds.coverage = 1.2", "clouds.coverage", "closest valid choice is 1"),
    ("platform.altitude = 500", "platform.altitude", "choice is 500000, which is 500 km"),
    ("platform.altitude = 5e8", "platform.altitude", "choice is 4.2e+07"),
    ("sea.temperature = 15", "sea.temperature", ">= 260 and <= 330", "choice is 288.15, which is 15 degC"),
    ("clouds.temperature = -20", "clouds.temperature", "choice is 253.15, which is -20 degC"),
    ("sea.temperature = 200", "sea.temperature", "choice is 260"),
    ("sea.temperature = '15 K'", "sea.temperature", "choice is 260"),
    (
        "optics.parameters.water_temperature_K = -5",
        "optics.parameters.water_temperature_K",
        "choice is 268.15, which is -5 degC",
    ),
    ("optics.parameters.radius_nodes = 3", "optics.parameters.radius_nodes", "choice is 50"),
    ("motion.evolution_time = 0", "motion.evolution_time", "0.001 to 1e12 s", "choice is 0.001"),
    ("motion.evolution_time = inf", "motion.evolution_time", "choice is 'frozen'"),
    ("motion.evolution_time = nan", "motion.evolution_time", "nan is out of range"),
    ("sea.wind_speed = nan", "sea.wind_speed", "nan is not a finite number", ">= 0 and <= 60"),
    ("clouds.top = inf", "clouds.top", "inf is not a finite number"),
    ("output.compression = 10", "output.compression", "choice is 9"),
    (f"title = '{'x' * 300}'", "title", "300 characters", "at most 200"),
    # units
    ("image.pixel_size = '10 kg'", "image.pixel_size", "'kg' is not a unit of length", "m, km, cm, ft"),
    ("image.pixel_size = '20 mm'", "image.pixel_size", "'mm' is not a unit of length"),
    ("sea.temperature = '5 degF'", "sea.temperature", "'degF'", "K, degC", "closest is 'degC'"),
    ("sea.temperature = '15 °C'", "sea.temperature", "closest is 'degC'"),
    ("motion.wind_speed = '10 mph'", "motion.wind_speed", "is not a unit of speed; allowed: a number in m/s"),
    ("motion.evolution_time = '30 mins'", "motion.evolution_time", "closest is 'min'"),
    ("image.pixel_size = 'abc'", "image.pixel_size", "'abc' is not a number with a unit"),
    # types
    ("image.pixel_size = true", "image.pixel_size", "true is not a number", "allowed: >= 0.001"),
    ("image.rows = true", "image.rows", "true is not a whole number"),
    ("image.rows = '8'", "image.rows", "'8' is not a whole number"),
    ("image.rows = 8.5", "image.rows", "8.5 is not a whole number"),
    ("accuracy = 'small'", "accuracy", "'small' is not an accuracy"),
    ("seed = true", "seed", "true is not a whole number"),
    ("title = 3", "title", "3 is not text"),
    ("image = 800", "image", "800 is not a table", "rows, columns, pixel_size"),
    ("clouds = 'stratus'", "clouds", "is not a table", "type, coverage", "{type = 'stratus'}"),
    ("clouds.parameters = [1]", "clouds.parameters", "[1] is not a table"),
    ("motion.wind_speed = [1]", "motion.wind_speed", "[1] is not a number"),
    ("sea.parameters.water_index = 3", "sea.parameters.water_index", "3 is not text"),
    (
        "radiance = {model = 'as-printed', parameters = {literal_eq14 = 3}}",
        "radiance.parameters.literal_eq14",
        "not true or false",
    ),
    ("motion.evolution_time = 'frozn'", "motion.evolution_time", "closest is 'frozen'"),
    ("motion.evolution_time = true", "motion.evolution_time", "true is not a duration"),
    # bands
    ("bands = [[5, 3]]", "bands[0]", "is reversed", "choice is [3, 5]"),
    ("bands = ['lwir-11']", "bands[0]", "no band named 'lwir-11'", "closest is 'lwir-10.8' (10.3 to 11.3 um)"),
    ("bands = ['mwir-4']", "bands[0]", "closest is 'mwir-3.4-4.1' (3.4 to 4.1 um)"),
    ("bands = ['8-14']", "bands[0]", "closest is 'lwir' (8 to 14 um)", "a band of your own is written [8.0, 14.0]"),
    ("bands = ['mwir-3.4-4.2']", "bands[0]", "closest is 'mwir-3.4-4.1' (3.4 to 4.1 um)", "is written [3.4, 4.2]"),
    ("bands = ['14-8um']", "bands[0]", "is reversed", "choice is [8, 14]"),
    ("bands = ['mwir5.5um']", "bands[0]", "closest is 'mwir-4.5-4.8' (4.5 to 4.8 um)"),
    ("output.quantization = '6 %'", "output.quantization", "'6 %' = 0.06 is out of range", "choice is 0.05"),
    ("bands = ['mwr']", "bands[0]", "no band named 'mwr'", "closest is 'mwir'"),
    ("bands = []", "bands", "is empty", "at least 1 entry"),
    ("bands = 'mwir'", "bands", "'mwir' is not a list", 'choice is ["mwir"]'),
    ("bands = [3, 5]", "bands", "single band", "choice is [[3, 5]]"),
    ("bands = [[3, nan]]", "bands[0]", "[3, nan] um is out of range"),
    ("bands = [[3, 3]]", "bands[0]", "no width"),
    ("bands = [[3.7, 3.7000000001]]", "bands[0]", "too narrow", "at least 1e-06"),
    ("bands = [['3 um', '5 um']]", "bands[0]", "two numbers from 0.1 to 1000"),
    ("bands = [[20, 30]]", "bands[0]", "20 to 30 um", "allowed: 0.70004 to 20 um"),
    ("bands = ['mwir', [3, 4], [3, 4.0]]", "bands", "'3-4um' given twice"),
    ("bands = [{name = 'x'}]", "bands[0].response", "is missing", "Text file with columns of wavelength"),
    ("bands = [{name = 'x', response = 'no.csv'}]", "bands[0].response", "no file 'no.csv'"),
    # names
    ("clouds.type = 'stratos'", "clouds.type", "neither in catalogs/cloud_types nor", "closest is 'stratus'"),
    (f"clouds.type = '{'x' * 300}'", "clouds.type", "neither in catalogs/cloud_types nor"),
    ("clouds.type = '~nobody-here/x.toml'", "clouds.type", "home directory"),
    ("clouds.generator = 'fractl'", "clouds.generator", "closest is 'fractal'"),
    ("clouds.anchor = 'botom'", "clouds.anchor", "'botom' is not a choice", "allowed: base, top"),
    ("sea.model = 'cox'", "sea.model", "no sea model is called 'cox'", "closest is 'cox-munk'"),
    ("optics.provider = 'mei'", "optics.provider", "closest is 'mie'"),
    ("radiance.model = 'printed'", "radiance.model", "closest is 'as-printed'"),
    ("atmosphere.provider = 'tabel'", "atmosphere.provider", "closest is 'table'"),
    ("atmosphere.profile = 'us-standard'", "atmosphere.profile", "closest is 'us-standard-1976'"),
    ("output.variables = ['radianc']", "output.variables", "'radianc'", "closest is 'radiance'"),
    ("output.variables = 'radiance'", "output.variables", 'choice is ["radiance"]'),
    # layers
    (
        "clouds = {type = 'paper-stratus', top = 20}",
        "clouds.top",
        "20 m is not above the base",
        "above 33",
        "type 'paper-stratus'",
    ),
    ("clouds = {type = 'paper-stratus', base = 1500}", "clouds.base", "1500 m is not below the top", "below 1000"),
    ("clouds = {base = 1500, top = 1500}", "clouds.top", "allowed: above 1500"),
    ("clouds = {type = 'paper-stratus', thickness_min = 5000}", "clouds.thickness_min", "choice is 967"),
    ("clouds.type = 'stratus'\n[[clouds.layers]]\ntype = 'cirrus'", "clouds", "'type' with [[clouds.layers]]"),
    (
        "".join(f"[[clouds.layers]]\nbase = {base}\ntop = {base + 900}\n" for base in range(0, 6000, 1000)),
        "clouds.layers",
        "6 entries",
        "at most 5",
    ),
    (
        "[[clouds.layers]]\ntype = 'paper-cumulus'\n[[clouds.layers]]\ntype = 'paper-stratus'\ncoverage = 0.1",
        "clouds.layers[0].base",
        "66 m (that of type 'paper-cumulus') lies below the top of clouds.layers[1], 1000 m",
        "must not overlap",
        "allowed: from 1000, or clouds.layers[1].top up to 66",
    ),
    (
        "[[clouds.layers]]\ntype = 'paper-cirrus'\nbase = 2999\n[[clouds.layers]]\ntype = 'paper-cumulus'",
        "clouds.layers[0].base",
        "2999 m lies below the top of clouds.layers[1], 3000 m (that of type 'paper-cumulus')",
        "allowed: from 3000",
    ),
    (
        "[[clouds.layers]]\ntype = 'paper-cumulus'\ntop = 6500\n[[clouds.layers]]\ntype = 'paper-cirrus'",
        "clouds.layers[0].top",
        "6500 m lies above the base of clouds.layers[1], 6000 m (that of type 'paper-cirrus')",
        "allowed: up to 6000, or clouds.layers[1].base from 6500",
    ),
    (
        "[[clouds.layers]]\n[[clouds.layers]]\nbase = 1000\ntop = 2000\nparameters = {H = 3}",
        "clouds.layers[1].parameters.H",
        "just below 1",
    ),
    ("image.samples_per_pixel = 65", "image.samples_per_pixel", ">= 1 and <= 64", "choice is 64"),
    ("image.samples_per_pixel = 1.5", "image.samples_per_pixel", "not a whole number"),
    ("output.variables = ['cloud_layer_thickness']", "output.variables", "the scene has no cloud layer"),
    ("clouds.layers.type = 'stratus'", "clouds.layers", "is not a list", "[[clouds.layers]]"),
    ("clouds.layers = [3]", "clouds.layers[0]", "3 is not a table"),
]


def test_a_parameter_of_a_provider_that_is_not_selected_is_told_with_its_provider():
    line = "clouds.generator = 'imagery'\nclouds.parameters.image = 'x.png'\nclouds.gamma = 2"
    told = refusal(TIME + PLACE + line)["clouds.gamma"]
    assert "closest is 'clouds.parameters.gamma', a parameter of cloud generator 'fractal'" in told
    assert told.endswith('with clouds.generator = "fractal"')


def test_parameters_of_a_provider_that_the_command_line_replaces_are_named():
    raw = {
        "time": EXAMPLE,
        "place": {"latitude": 35, "longitude": 150},
        "clouds": {"type": "stratus", "generator": "imagery", "parameters": {"image": "a.png", "copies": 2}},
    }
    replaced = Scenario.from_dict(raw, {"clouds.generator": "fractal"})
    (note,) = replaced.notes
    assert note.startswith("clouds.generator = 'fractal'")
    assert note.endswith("image, copies")
    # the file does not name the generator, and the command line names the default: nothing is replaced
    del raw["clouds"]["generator"]
    raw["clouds"]["parameters"] = {"H": 0.3}
    same = Scenario.from_dict(raw, {"clouds.generator": "fractal"})
    assert (same.notes, dict(same.clouds.layers[0].parameters)) == ((), {"H": 0.3})


def test_a_misplaced_parameter_given_on_the_command_line_is_named_as_it_was_typed():
    assert "'clouds.parameters.gamma'" in refusal(TIME + PLACE, {"clouds.gamma": 2})["clouds.gamma"]


def test_rounding_may_be_given_in_percent():
    assert Scenario.load("stratus", {"output.quantization": "0.02 %"}).output.quantization == 0.02 / 100


@pytest.mark.parametrize(("line", "field", "parts"), [(line, field, parts) for line, field, *parts in WRONG])
def test_one_mistake_gives_one_problem_at_the_key_that_was_typed(line, field, parts, tmp_path):
    problems = refusal(TIME + PLACE + line, base=tmp_path)
    assert field in problems
    for part in parts:
        assert part in problems[field]
    if "name = 'x'" not in line:  # a response band with a key missing has a second mistake
        assert list(problems) == [field]


@pytest.mark.parametrize(
    ("time", "part"),
    [
        ("2024-04-20T12:30:00", "in UTC is 2024-04-20T12:30:00+00:00"),
        ("'2024-04-20T12:30:00'", "in UTC is 2024-04-20T12:30:00+00:00"),
        ("2024-04-20", "choice is 2024-04-20T00:00:00+00:00"),
        ("12:30:00", "12:30:00 is not a date and time"),
        ("1713580200", EXAMPLE),
        ("1713580200.0", EXAMPLE),
        ("'1713580200'", EXAMPLE),
        ("true", "true is not a date and time"),
        ("'noon'", EXAMPLE),
        ("[2024]", EXAMPLE),
        ("'2024-04-20T12:30:00+10:00:30'", "whole minutes"),
        ("0001-01-01T00:00:00+10:00", "years 1 to 9999"),
    ],
)
def test_time_must_be_an_instant(time, part):
    assert part in refusal(f"time = {time}\n{PLACE}")["time"]


@pytest.mark.parametrize("time", ["2024-04-20T12:30:00+10:00", "'2024-04-20T02:30:00Z'", "'2024-04-20 12:30+10:00'"])
def test_an_instant_may_be_text(time):
    assert Scenario.from_toml(f"time = {time}\n{PLACE}").time.timestamp() == 1713580200


def test_every_mistake_is_named_at_once():
    text = f"""{TIME}
        place = {{longitude = 400}}
        view = {{zenith = 99, foo = 1}}
        bands = ["q", [4, 3]]
        clouds = {{coverage = 2, type = "x", top = nan, parameters = {{H = 3, L = [1, 0], zz = 1}}}}
        sea.model = "flat"
    """
    assert set(refusal(text)) == {
        "place.latitude", "place.longitude", "view.zenith", "view.foo", "bands[0]", "bands[1]", "clouds.coverage",
        "clouds.type", "clouds.top", "clouds.parameters.H", "clouds.parameters.L[1]", "clouds.parameters.zz",
        "sea.model",
    }  # fmt: skip


def test_an_empty_scenario_asks_for_what_is_required():
    problems = refusal("")
    assert set(problems) == {"time", "place"}
    assert all(message.startswith("is missing") and "for example" in message for message in problems.values())


STRATUS = (catalog_root() / "cloud_types" / "paper-stratus.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("old", "new", "parts"),
    [
        ("gamma =", "gama =", ["fractal.gama: unknown key", "closest is 'gamma'", "fractal.gamma: is missing"]),
        ("H = 0.8", "H = 1.8", ["fractal.H: 1.8 is out of range"]),
        ("L = [10, 10]", "L = [-1, nan]", ["fractal.L[0]: -1", "closest valid choice is 0.001", "fractal.L[1]: nan"]),
        ("k = [0, 4]", "k = [4, 0]", ["fractal.k: [4, 0] descends", "closest is [0, 4]"]),
        ('"water"', '"wader"', ["the density of 'wader' is unknown", "closest is 'water'"]),
        ("top = 1000.0", "top = '10 m'", ["top 10 m is not above the base", "above 33"]),
        ("thickness_min = 10.0", "thickness_min = 999.0", ["thickness_min 999 m", "choice is 967"]),
        ("[0.02, 50.0]", "[50.0, 0.02]", ["radius_range_um: [50, 0.02] is not a range"]),
        ("b = 0.193", "b = true", ["microphysics.b: true is not a number"]),
        (
            "b = 0.193",
            "effective_radius_um = 10.0",
            ["alpha, nu, number_density given together with effective_radius_um", "either alpha, b"],
        ),
        ("b = 0.193", "", ["microphysics: b missing; allowed: either alpha, b, nu"]),
        ("[layer]", "[[layer", ["not valid TOML"]),
    ],
)
def test_a_cloud_type_file_of_the_user_is_checked_with_the_scenario(old, new, parts, tmp_path):
    (tmp_path / "mine.toml").write_text(STRATUS.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ScenarioError) as caught:
        Scenario.from_toml(TIME + PLACE + "clouds.type = 'mine.toml'\nview.zenith = 99", base=tmp_path)
    problems = caught.value.problems
    assert {problem.field for problem in problems} == {"clouds.type", "view.zenith"}
    text = str(caught.value)
    for part in ["mine.toml", *parts]:
        assert part in text


@pytest.mark.parametrize(
    ("content", "part"),
    [
        (b"wavelength_um,a,b\n3,1,1\n4,1,1\n", "column = one of a, b"),
        (b"wavelength_um,response\n3,1\n4,nan\n", "line 3: nan is not finite"),
        (b"wavelength_um,response\n3,one\n4,1\n", "line 2"),
        (b"wavelength_um,response\n4,1\n3,1\n3.5,1\n", "line 4: 3.5 after 3"),
        (b"wavelength_um,response\n3,-1\n4,1\n", "0..1"),
        (b"wavelength_um,response\n3,0\n4,0\n", "positive somewhere"),
        (b"wavelength_um,response\n3,1\n3.0000000001,1\n", "too narrow"),
        (b"", "no rows"),
        (bytes(range(256)), "not a text file"),
    ],
)
def test_a_response_file_is_checked_with_the_scenario(content, part, tmp_path):
    (tmp_path / "r.csv").write_bytes(content)
    problems = refusal(TIME + PLACE + "bands = [{name = 'x', response = 'r.csv'}]\nview.zenith = 99", base=tmp_path)
    assert set(problems) == {"bands[0].response", "view.zenith"}
    assert part in problems["bands[0].response"]


@pytest.mark.parametrize(
    ("content", "part"),
    [(b"altitude_m,pressure_Pa\n0,1e5\n1000,9e4\n", "temperature is missing"), (bytes(range(256)), "not a text file")],
)
def test_a_profile_file_is_checked_with_the_scenario(content, part, tmp_path):
    (tmp_path / "p.csv").write_bytes(content)
    problems = refusal(TIME + PLACE + "atmosphere.profile = 'p.csv'\nview.zenith = 99", base=tmp_path)
    assert set(problems) == {"atmosphere.profile", "view.zenith"}
    assert part in problems["atmosphere.profile"]


@pytest.mark.parametrize(
    ("name", "content", "part"),
    [
        ("a.toml", b"x = = 3", "not valid TOML"),
        ("a.toml", b"title = 'a'\ntitle = 'b'", "not valid TOML"),
        ("a.toml", bytes(range(256)), "not a text file"),
        ("a.toml", b"a = " + b"[" * 5000, "nested too deeply"),
        ("a.toml", b"seed = " + b"9" * 5000, "not valid TOML"),
        ("a.json", b"{", "not valid JSON"),
        ("a.json", b"[]", "[] is not a table of keys"),
        ("a.json", b'{"time": 1, "time": 2}', "'time' is given twice"),
        ("a.json", b"[" * 100_000, "nested too deeply"),
        ("a.json", b'{"title": "\\ud800"}', "not valid JSON"),
    ],
)
def test_files_that_are_no_scenario(name, content, part, tmp_path):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ScenarioError, match=name) as caught:
        Scenario.load(tmp_path / name)
    assert part in str(caught.value)


@pytest.mark.parametrize("source", ["", ".", "stratuss", "nope.toml", "x" * 300, "~nobody-here/a.toml"])
def test_sources_that_are_no_file(source):
    with pytest.raises(ScenarioError, match="file: "):
        Scenario.load(source)
    if source == "stratuss":
        with pytest.raises(ScenarioError, match="closest is 'stratus'"):
            Scenario.load(source)


@pytest.mark.parametrize("raw", [None, 3, [], "x", {1: 2}, {"view": {1: 2}}])
def test_mappings_that_are_no_scenario(raw):
    with pytest.raises(ScenarioError):
        Scenario.from_dict(raw)


def test_endless_nesting_is_refused():
    deep = []
    deep.append(deep)
    with pytest.raises(ScenarioError, match="nested too deeply"):
        Scenario.from_dict({"view": deep})


@pytest.mark.parametrize(
    ("key", "value", "field", "part"),
    [
        ("view.zenit", 1, "view.zenit", "closest is 'zenith'"),
        ("view.zenith.x", 1, "view.zenith.x", "not a table"),
        ("view..zenith", 1, "'view..zenith'", "is not a key"),
        ("", 1, "''", "is not a key"),
        ("bands.9", "mwir", "bands.9", "allowed: 0 to 2"),
        ("bands.²", "mwir", "bands", "is not a list"),
        ("clouds.layers.3.type", "x", "clouds.layers.3.type", "allowed: 0 to 0"),
        ("clouds.coverage", 2, "clouds.coverage", "choice is 1"),
        ("clouds.parameters", {"H": 7}, "clouds.parameters.H", "just below 1"),
        ("clouds", 3, "clouds", "not a table"),
        ("time.year", 2024, "time.year", "not a table"),
        ("place.latitude", None, "place.latitude", "None is not a number"),
    ],
)
def test_overrides_into_nonsense(key, value, field, part):
    for source in ({"type": "stratus"}, {"layers": [{"type": "stratus"}]}):
        raw = {"time": EXAMPLE, "place": {"latitude": 35, "longitude": 150}, "clouds": source, "view": {"zenith": 1.0}}
        with pytest.raises(ScenarioError) as caught:
            Scenario.from_dict(raw, {key: value})
        (problem,) = caught.value.problems
        assert problem.field == field
        assert part in problem.message


def test_an_override_of_what_is_no_table_names_both():
    with pytest.raises(ScenarioError, match=r"clouds\.type: clouds is 3, not a table"):
        Scenario.from_dict(json.loads('{"clouds": 3}'), {"clouds.type": "stratus"})


@pytest.mark.parametrize("wrong", ["'stratos'", "'no/such.toml'", "3"])
def test_a_wrong_type_does_not_hide_what_is_wrong_with_the_altitudes(wrong):
    upside_down = refusal(TIME + PLACE + f"clouds = {{type = {wrong}, base = 3000, top = 2000}}")
    assert "allowed: above 3000" in upside_down["clouds.top"]
    assert "clouds.type" in upside_down
    thin = refusal(TIME + PLACE + f"clouds = {{type = {wrong}, base = 10, top = 20, thickness_min = 30}}")
    assert set(thin) == {"clouds.type", "clouds.thickness_min"}


def test_layers_of_a_wrong_type_may_not_overlap_either():
    layers = """
[[clouds.layers]]
type = "stratos"
base = 100
top = 8000
[[clouds.layers]]
type = "paper-cirrus"
"""
    found = refusal(TIME + PLACE + layers)
    assert set(found) == {"clouds.layers[0].type", "clouds.layers[0].top"}
    assert "must not overlap" in found["clouds.layers[0].top"]


def test_a_time_within_a_leap_second_is_told_with_the_closest_one():
    problems = refusal("time = '2016-12-31T23:59:60.5+00:00'\n" + PLACE)
    assert "is within a leap second" in problems["time"]
    assert "closest valid choice is 2016-12-31T23:59:59+00:00" in problems["time"]
