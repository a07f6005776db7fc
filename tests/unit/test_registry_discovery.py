import json
import subprocess
import sys
from types import SimpleNamespace

import pytest
from click.testing import CliRunner

from hcss_twin.cli import cli
from hcss_twin.core.errors import ProviderError
from hcss_twin.core.plugins import installed
from hcss_twin.providers.registry import API_VERSION, Kind, Origin, ProviderSpec, Registry, defaults, hookimpl
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scenario.section_types import own, selected
from hcss_twin.version import __version__

HOOK = Kind.ATMOSPHERE.hook


def spec(name="grey", api_version=API_VERSION):
    return ProviderSpec(name=name, target="nowhere:Class", parameters=None, api_version=api_version, summary="a gas")


def plugin(result=None, hook=HOOK, mark=hookimpl, error=None):
    def function():
        if error is not None:
            raise error
        return result

    return SimpleNamespace(**{hook: mark(function) if mark else function})


def origin(distribution="hcss-a", version="1.2", entry_point="a"):
    return Origin(entry_point, distribution, version)


def registry_with(*plugins):
    registry = Registry()
    registry.add(defaults, origin("hcss-twin"))
    for each, where in plugins:
        registry.add(each, where)
    return registry


def test_defaults_are_registered_through_the_hooks():
    names = {str(kind): Registry.discover().names(kind) for kind in Kind}
    assert set(names["clouds"]) >= {"fractal", "imagery"}
    assert "cox-munk" in names["sea"]
    assert "mie" in names["optics"]
    assert "table" in names["atmosphere"]
    assert "as-printed" in names["radiance"]


def test_default_names_resolve_whatever_is_installed():
    registry = Registry.discover()
    silent = Scenario.from_dict(
        {"time": "2024-04-20T12:30:00Z", "place": {"latitude": 0, "longitude": 0}, "clouds": {"type": "cirrus"}}
    )
    names = {
        Kind.CLOUDS: selected(silent.clouds.layers[0], "generator"),
        Kind.SEA: selected(silent.sea, "model"),
        Kind.OPTICS: selected(silent.optics, "provider"),
        Kind.ATMOSPHERE: selected(silent.atmosphere, "provider"),
        Kind.RADIANCE: selected(silent.radiance, "model"),
    }
    for kind, name in names.items():
        assert registry.resolve(kind, name).qualified_name == name


def test_default_names_stay_unambiguous_beside_a_duplicate():
    registry = registry_with((plugin([spec("table")]), origin()))
    entry = registry.resolve("atmosphere", own("table"))
    assert entry.distribution == "hcss-twin"


def test_plugin_is_listed_with_distribution_and_version():
    registry = registry_with((plugin([spec()]), origin()))
    [entry] = [entry for entry in registry.entries() if entry.name == "grey"]
    assert (entry.kind, entry.distribution, entry.version, entry.summary) == ("atmosphere", "hcss-a", "1.2", "a gas")
    assert registry.broken == ()
    assert registry.resolve("atmosphere", "grey") is entry


class Malformed:
    """An object that is angry when looked at."""

    def __dir__(self):
        raise RuntimeError("do not look at me")


class Wrapper:
    """Wraps the hook calls of others, if it is let."""

    @hookimpl(wrapper=True)
    def hcss_register_transmittance_providers(self):
        yield
        return []


BROKEN = {
    "raises": (plugin(error=RuntimeError("boom")), "RuntimeError: boom"),
    "exits": (plugin(error=SystemExit(3)), "SystemExit: 3"),
    "misspelt": (plugin([spec()], hook="hcss_register_transmitance_providers"), f"did you mean '{HOOK}'"),
    "unmarked": (plugin([spec()], mark=None), "lacks the @hookimpl mark"),
    "empty": (SimpleNamespace(), "no hook found"),
    "none": (plugin(None), "returned None"),
    "a single spec": (plugin(spec()), "returned ProviderSpec; expected a list"),
    "generator": (plugin(each for each in [spec()]), "returned generator"),
    "text": (plugin("grey"), "returned str"),
    "list of text": (plugin(["grey"]), "list with str"),
    "twice": (plugin([spec(), spec()]), "'grey' twice"),
    "malformed": (Malformed(), "do not look at me"),
    "arguments": (SimpleNamespace(**{HOOK: hookimpl(lambda surprise: [])}), "surprise"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_broken_plugin_is_kept_apart(case):
    bad, message = BROKEN[case]
    good = origin("hcss-good", entry_point="good")
    registry = registry_with((bad, origin()), (plugin([spec("good")]), good))
    [broken] = registry.broken
    assert message in broken.error
    assert (broken.entry_point, broken.distribution, broken.version) == ("a", "hcss-a", "1.2")
    assert registry.resolve("atmosphere", "good").distribution == "hcss-good"
    assert registry.resolve("atmosphere", "table").distribution == "hcss-twin"
    assert not [entry for entry in registry.entries() if entry.distribution == "hcss-a"]


@pytest.mark.parametrize("version", [API_VERSION - 1, API_VERSION + 1])
def test_another_api_version_is_refused_with_the_supported_one_and_the_page(version):
    registry = registry_with((plugin([spec(api_version=version)]), origin()))
    [broken] = registry.broken
    assert str(broken).startswith("hcss-a 1.2 ")
    assert f"version {version} of the provider API" in broken.error
    assert f"hcss_twin {__version__} supports version {API_VERSION} (docs/reference/provider-api.md)" in broken.error
    with pytest.raises(ProviderError, match="'grey' is written for version"):
        registry.resolve("atmosphere", "grey")


LATER = "hcss_register_cameras"
"""A hook that this version lacks, as an older engine lacks those of later versions."""


def two_hooks(other, mark):
    """A plugin with a gas and a second hook, which would fail if it were called."""
    gas = plugin([spec()])
    vars(gas)[other] = mark(lambda surprise: 1 / 0)
    return gas


@pytest.mark.parametrize(
    ("other", "mark", "topic", "said"),
    [
        (
            LATER,
            hookimpl(optionalhook=True),
            "optional hook",
            f"'{LATER}' is ignored: hcss_twin {__version__} does not",
        ),
        (LATER, hookimpl, "unknown hook", f"'{LATER}'"),
        ("hcss_register_optic", hookimpl, "unknown hook", "(did you mean 'hcss_register_optics'?) is ignored"),
    ],
)
def test_unknown_hook_is_remarked_and_breaks_nothing(other, mark, topic, said):
    registry = registry_with((two_hooks(other, mark), origin()))
    assert not registry.broken
    assert registry.resolve("atmosphere", "grey").distribution == "hcss-a"
    [remark] = registry.remarks
    assert (remark.topic, remark.origin) == (topic, origin())
    assert said in str(remark)
    with pytest.raises(ProviderError, match=r"might come from a hook that is not used: hcss-a 1\.2"):
        registry.resolve("optics", "soot")


def test_plugin_whose_only_hook_is_optional_and_unknown_is_not_broken():
    later = registry_with((plugin([], hook=LATER, mark=hookimpl(optionalhook=True)), origin()))
    assert not later.broken
    assert [each.topic for each in later.remarks] == ["optional hook"]


def test_hook_may_have_a_function_of_another_name():
    named = SimpleNamespace(gases=hookimpl(specname=HOOK)(lambda: [spec()]))
    registry = registry_with((named, origin()))
    assert not registry.broken
    assert not registry.remarks
    assert "grey" in registry.names("atmosphere")


def test_plugin_cannot_wrap_the_hooks_of_others():
    registry = registry_with((Wrapper(), origin()), (plugin([spec()]), origin("hcss-b")))
    assert registry.names("atmosphere") == ("band-model", "grey", "table")


def test_interrupt_is_not_swallowed():
    with pytest.raises(KeyboardInterrupt):
        registry_with((plugin(error=KeyboardInterrupt()), origin()))


def test_duplicate_is_an_error_that_names_both_only_when_selected():
    registry = registry_with((plugin([spec()]), origin()), (plugin([spec()]), origin("hcss-b", "0.9")))
    assert registry.names("atmosphere") == ("band-model", "hcss-a/grey", "hcss-b/grey", "table")
    with pytest.raises(ProviderError) as error:
        registry.resolve("atmosphere", "grey")
    for part in ("hcss-a 1.2", "hcss-b 0.9", '"hcss-a/grey"', '"hcss-b/grey"'):
        assert part in str(error.value)
    assert registry.resolve("atmosphere", "hcss-b/grey").version == "0.9"


def test_qualified_name_always_works_and_folds_the_distribution():
    registry = registry_with((plugin([spec()]), origin("Hcss_A")))
    assert registry.resolve("atmosphere", "hcss-a/grey").name == "grey"
    assert registry.resolve("atmosphere", "hcss-twin/table").name == "table"


def test_same_name_may_stand_for_different_kinds():
    registry = registry_with((plugin([spec("mie")]), origin()))
    assert registry.resolve("optics", "mie").distribution == "hcss-twin"
    assert registry.resolve("atmosphere", "mie").distribution == "hcss-a"


def test_one_distribution_cannot_bring_a_name_twice():
    registry = registry_with((plugin([spec()]), origin()), (plugin([spec()]), origin(entry_point="b")))
    assert "also registered by the entry point 'a'" in registry.broken[0].error
    assert registry.resolve("atmosphere", "grey").origin.entry_point == "a"


def test_unknown_name_gets_the_closest_and_what_to_install():
    with pytest.raises(ProviderError, match=r"allowed: fractal, imagery; closest is 'fractal'.*pip install"):
        registry_with().resolve("clouds", "fractle")
    with pytest.raises(ProviderError, match="It comes with hcss-skies"):
        registry_with().resolve("clouds", "surrogate")
    with pytest.raises(ProviderError, match="closest is 'hcss-twin/table'"):
        registry_with().resolve("atmosphere", "hcss-win/table")


def test_unknown_name_points_to_the_broken_plugin_that_offered_it():
    registry = registry_with(
        (plugin([spec(api_version=7)]), origin()), (plugin(error=RuntimeError("boom")), origin("hcss-b"))
    )
    with pytest.raises(ProviderError) as error:
        registry.resolve("atmosphere", "grey")
    assert "would come from" in str(error.value)
    assert "hcss-a 1.2 (entry point 'a'): 'grey' is written for version 7" in str(error.value)
    assert "hcss-b" not in str(error.value)
    with pytest.raises(ProviderError, match=r"might come from .*version 7.*hcss-b.*boom"):
        registry.resolve("atmosphere", "unheard-of")


def test_unknown_kind_is_refused():
    with pytest.raises(ValueError, match="weather"):
        registry_with().resolve("weather", "grey")


def install(folder, distribution, version, entry_points):
    info = folder / f"{distribution.replace('-', '_')}-{version}.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: {version}\n")
    (info / "entry_points.txt").write_text(entry_points)


def test_entry_points_are_read_one_distribution_at_a_time(tmp_path, monkeypatch):
    install(tmp_path, "aaa-garbage", "1", "[hcss_twin]\nthis is no entry point\n")
    install(tmp_path, "bbb-missing", "2", "[hcss_twin]\nm = no_such_module_anywhere\n")
    install(tmp_path, "ccc-raises", "3", "[hcss_twin]\nr = hcss_plugin_that_raises\n")
    install(tmp_path, "ddd-exits", "4", "[hcss_twin]\ne = hcss_plugin_that_exits\n")
    install(tmp_path, "eee-good", "5", "[hcss_twin]\ng = hcss_plugin_that_works\n[other]\nx = y\n")
    (tmp_path / "hcss_plugin_that_raises.py").write_text("1 / 0\n")
    (tmp_path / "hcss_plugin_that_exits.py").write_text("import sys; sys.exit('bye')\n")
    (tmp_path / "hcss_plugin_that_works.py").write_text(
        "from hcss_twin.providers.registry import ProviderSpec, hookimpl\n"
        "@hookimpl\n"
        "def hcss_register_optics():\n"
        "    return [ProviderSpec('shiny', 'not_imported:Yet', None, 3, 'shiny')]\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    registry = Registry.discover()
    errors = {broken.distribution: broken.error for broken in registry.broken}
    assert set(errors) >= {"aaa-garbage", "bbb-missing", "ccc-raises", "ddd-exits"}
    assert "no_such_module_anywhere" in errors["bbb-missing"]
    assert "ZeroDivisionError" in errors["ccc-raises"]
    assert "SystemExit: bye" in errors["ddd-exits"]
    assert str(registry.resolve("optics", "shiny").origin) == "eee-good 5"


REGISTERS = """
from hcss_twin.providers.registry import ProviderSpec, hookimpl
@hookimpl
def hcss_register_optics():
    return [ProviderSpec('shiny', 'not_imported:Yet', None, 3, 'shiny')]
"""


def test_only_metadata_is_read_until_a_name_may_be_of_a_plugin(tmp_path, monkeypatch):
    install(tmp_path, "fff-lazy", "1", "[hcss_twin]\nl = hcss_plugin_imported_late\n")
    (tmp_path / "hcss_plugin_imported_late.py").write_text(REGISTERS)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "hcss_plugin_imported_late", raising=False)
    registry = Registry.discover()
    registry.resolve("optics", own("mie"))
    assert "hcss_plugin_imported_late" not in sys.modules
    registry.resolve("optics", "fff-lazy/shiny")
    assert "hcss_plugin_imported_late" in sys.modules


@pytest.mark.parametrize("group", ["hcss_twin", "hcss_twin.commands"])
def test_slow_import_is_named_by_hcss_plugins(tmp_path, monkeypatch, group):
    name = f"hcss_plugin_slow_{len(group)}"
    install(tmp_path, "ggg-slow", "1", f"[{group}]\ns = {name}\n")
    hook = "from hcss_twin.core.commands import hookimpl\n@hookimpl\ndef hcss_commands(): return []\n"
    (tmp_path / f"{name}.py").write_text("import time; time.sleep(0.35)\n" + REGISTERS + hook)
    monkeypatch.syspath_prepend(tmp_path)
    done = CliRunner().invoke(cli, ["plugins"])
    assert f"remark: ggg-slow 1 (entry point 's'): the import of '{name}' took 0." in done.output
    monkeypatch.delitem(sys.modules, name)
    remarks = json.loads(CliRunner().invoke(cli, ["plugins", "--json"]).stdout)["remarks"]
    assert ("ggg-slow", "slow import") in {(each["distribution"], each["topic"]) for each in remarks}


def test_first_of_two_installations_of_a_distribution_counts(tmp_path, monkeypatch):
    for folder, version in (("late", "1"), ("early", "2")):
        install(tmp_path / folder, "my-plugin", version, "[hcss_twin]\nm = no_such_module_anywhere\n")
        monkeypatch.syspath_prepend(tmp_path / folder)
    found = [where for where, _ in installed("hcss_twin") if where.distribution == "my-plugin"]
    assert [where.version for where in found] == ["2"]


def test_discovery_imports_nothing_heavy():
    code = (
        "from hcss_twin.providers.registry import Registry, Kind; import sys\n"
        "registry = Registry.discover(); registry.resolve(Kind.CLOUDS, 'hcss-twin/fractal')\n"
        "print(*sorted({'numpy', 'scipy', 'pydantic', 'xarray', 'hcss_twin.providers.clouds'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
