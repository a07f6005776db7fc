"""``hcss check``: installed providers are held to the kit in a process of their own."""

import json
import re
import textwrap

import pytest
from click.testing import CliRunner
from hcss_author.check import check_provider, find

from hcss_twin.cli.main import cli
from hcss_twin.core.errors import OptionError, ProviderError
from hcss_twin.providers.registry import Registry

SEA = """
    import os
    import time

    from hcss_twin.providers import ProviderSpec, hookimpl

    @hookimpl
    def hcss_register_sea_models():
        return [ProviderSpec(name, f"strange_seas:{name.title()}", None, 3, "a test sea") for name in
                ("good", "bright", "endless", "deadly", "known", "misnamed")]

    class Good:
        def __init__(self, inputs, parameters):
            from hcss_twin.providers import SeaDeclaration
            self.declares = SeaDeclaration()

        def emissivity(self, wavenumber_cm1, mu):
            import numpy as np
            return np.full((mu.size, wavenumber_cm1.size), 0.9)

        def brdf(self, wavenumber_cm1, mu_out, mu_in, relative_azimuth):
            import numpy as np
            return np.full((mu_out.size, wavenumber_cm1.size), 0.1 / np.pi)

    class Bright(Good):
        def brdf(self, *arguments):
            return 1.5 * super().brdf(*arguments)

    class Known(Bright):
        expected_failures = {"no more is reflected than is not emitted": "foam is counted twice"}

    class Misnamed(Bright):
        expected_failures = {"brdf is recipocal": "a slip"}

    class Endless(Good):
        def brdf(self, *arguments):
            while True:
                time.sleep(0.1)

    class Deadly(Good):
        def brdf(self, *arguments):
            os._exit(3)
"""


@pytest.fixture
def strange_seas(tmp_path, monkeypatch):
    """Six seas, installed."""
    (tmp_path / "strange_seas.py").write_text(textwrap.dedent(SEA))
    info = tmp_path / "strange_seas-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: strange-seas\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[hcss_twin]\nseas = strange_seas\n")
    monkeypatch.syspath_prepend(tmp_path)


def outcomes(result):
    return {law.name: law.outcome for law in result.laws}


def checked(name, parameters=None, limit_s=60.0):
    return check_provider(find(Registry.discover(), name), parameters, limit_s)


def test_a_provider_that_keeps_the_laws_passes_with_its_cost_per_call(strange_seas):
    done = CliRunner().invoke(cli, ["check", "good", "--json"])
    assert done.exit_code == 0, done.output
    answer = json.loads(done.output)
    assert answer["passed"]
    laws = {law["name"]: law for law in answer["laws"]}
    assert laws["brdf is reciprocal"]["outcome"] == "passed"
    skipped = [law for law in laws.values() if law["outcome"] == "not applicable"]
    assert skipped
    assert all(law["why"] for law in skipped)
    costs = {cost["member"]: cost for cost in answer["costs"]}
    assert set(costs) == {"Good", "emissivity", "brdf"}
    assert all(cost["calls"] > 0 and 0.0 < cost["median_s"] <= cost["most_s"] for cost in costs.values())


def test_a_wrong_provider_is_refused_by_the_name_of_the_law_with_its_numbers(strange_seas):
    done = CliRunner().invoke(cli, ["check", "strange-seas/bright"])
    assert done.exit_code == 1
    [failed] = [line for line in done.output.splitlines() if line.startswith("  failed")]
    assert failed.split(None, 1)[1] == "no more is reflected than is not emitted"
    assert "hemispherical integral of the BRDF does not exceed 1 - emissivity" in done.output
    assert "at mu = 1.0" in done.output
    assert "0.15" in done.output
    assert "1 failed" in done.output


def test_a_call_that_does_not_return_is_stopped_and_named_and_laws_that_do_not_need_it_are_run(strange_seas):
    result = checked("endless", limit_s=1.5)
    assert not result.passed
    first, second = [law for law in result.laws if law.outcome == "failed"]
    assert re.match(r"brdf\(array \(\d+,\).*\) did not return within 1.5 s", first.why)
    assert second.why.startswith("brdf(")
    rest = [law for law in result.laws if law.outcome == "not run"]
    assert rest
    assert all(law.why == "brdf() did not return in earlier laws" for law in rest)
    assert outcomes(result)["emissivity shape type and range"] == "passed"
    assert outcomes(result)["sea emits most upward"] == "passed"


def test_a_call_that_ends_the_process_is_named(strange_seas):
    law, _ = [law for law in checked("deadly").laws if law.outcome == "failed"]
    assert law.why.startswith("brdf(")
    assert "ended the process (exit code 3)" in law.why


def test_expected_failures_are_named_with_their_reason_and_a_wrong_name_is_refused(strange_seas):
    result = checked("known")
    assert result.passed
    [law] = [law for law in result.laws if law.outcome == "expected failure"]
    assert (law.name, law.why) == ("no more is reflected than is not emitted", "foam is counted twice")
    with pytest.raises(ProviderError, match=r"names 'brdf is recipocal'.*closest is 'brdf_is_reciprocal'"):
        checked("misnamed")


@pytest.mark.parametrize(
    ("name", "kind", "error", "message"),
    [
        ("cox-monk", None, OptionError, "closest is 'cox-munk'"),
        ("cox-munk", "see", OptionError, "--kind is 'see'.*closest is 'sea'"),
        ("cox-munk", "optics", OptionError, "no optics is called 'cox-munk'; allowed: bulk, mie"),
    ],
)
def test_an_unknown_provider_is_refused_with_the_closest(name, kind, error, message):
    with pytest.raises(error, match=message):
        find(Registry.discover(), name, kind)


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("imagery", {}, "cloud generator 'imagery'.*--set KEY=VALUE.*image, entry: neither given"),
        ("radiometer", {"psv": "airy"}, "psv: Extra inputs are not permitted"),
    ],
)
def test_parameters_that_are_missing_or_unknown_are_named(name, parameters, message):
    with pytest.raises(ProviderError, match=message):
        checked(name, parameters)


def test_a_builtin_provider_passes():
    assert checked("radiometer").passed


# A campaign: test_registry_builtins.py holds all of them to the same laws, and the command reaches laws of all kinds in
# one way, that of the test above.
@pytest.mark.campaign
@pytest.mark.parametrize("name", ["fractal", "cox-munk", "mie", "band-model", "as-printed"])
def test_a_dear_builtin_provider_passes(name):
    result = checked(name, limit_s=300.0)
    assert result.passed, [law for law in result.laws if law.outcome == "failed"]
