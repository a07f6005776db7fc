"""``hcss report`` of a file for which a package brings the page."""

import sys
import types
from importlib.metadata import EntryPoint

import netCDF4
import pytest

import hcss_twin
from hcss_twin.core.errors import HcssError
from hcss_twin.core.plugins import Origin
from hcss_twin.reports.page import Page


@pytest.fixture
def install(monkeypatch):
    """Return a function after which the installed pages are those of these targets by attribute of files."""

    def install(**targets):
        entries = [(Origin(name, "visitor", "1.2"), EntryPoint(name, target, "-")) for name, target in targets.items()]
        monkeypatch.setattr("hcss_twin.reports.report.installed", lambda group: entries)

    module = types.ModuleType("visitor")
    module.page = lambda path: Page("title of a visitor", path.name, [Page.Section("One", ["text"])])
    monkeypatch.setitem(sys.modules, "visitor", module)
    return install


@pytest.fixture
def file(tmp_path):
    def file(**attributes):
        with netCDF4.Dataset(tmp_path / "a.nc", "w") as opened:
            opened.setncatts(attributes)
        return tmp_path / "a.nc"

    return file


def test_a_file_has_the_page_of_the_package_that_names_its_attribute(install, file):
    install(other_mark="visitor:absent", visitor_mark="visitor:page")
    assert "title of a visitor" in hcss_twin.report(file(visitor_mark=1)).read_text(encoding="utf-8")


def test_a_page_that_cannot_be_imported_is_the_fault_of_its_package(install, file):
    install(visitor_mark="visitor:absent")
    with pytest.raises(HcssError, match=r"'visitor_mark' of visitor 1\.2.*absent"):
        hcss_twin.report(file(visitor_mark=1))


@pytest.mark.parametrize(
    ("mark", "plugin"),
    [
        ("hcss_posterior_version", "hcss-evaluate"),
        ("hcss_propagation_version", "hcss-uncertainty"),
        ("hcss_sweep", "hcss-sweep"),
    ],
)
def test_a_file_whose_package_is_not_installed_names_it(install, file, mark, plugin):
    install()
    with pytest.raises(HcssError, match=f"plugin {plugin}: pip install"):
        hcss_twin.report(file(**{mark: 1}))


def test_a_folder_has_the_page_of_the_package_that_names_a_file_in_it(install, tmp_path):
    install(**{"visitor.txt": "visitor:page"})
    with pytest.raises(HcssError, match=r"a folder without index\.json of a sweep; allowed: .*"):
        hcss_twin.report(tmp_path)
    (tmp_path / "visitor.txt").touch()
    assert "title of a visitor" in hcss_twin.report(tmp_path).read_text(encoding="utf-8")


def test_a_folder_whose_package_is_not_installed_names_it(install, tmp_path):
    install()
    (tmp_path / "index.json").touch()
    with pytest.raises(HcssError, match="plugin hcss-sweep: pip install"):
        hcss_twin.report(tmp_path)
