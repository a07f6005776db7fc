"""What a plan found out, kept between runs under a name that says all it depends on."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from hcss_twin.cache.fingerprint import package_fingerprint, top_level
from hcss_twin.cache.kinds import PLANS
from hcss_twin.cache.records import read_record, write_record
from hcss_twin.cache.store import Store
from hcss_twin.catalog import Catalog, SecludedCatalog
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scene.accuracy import RequestedAccuracy
from hcss_twin.scene.building.assembly import Assembly
from hcss_twin.scene.findings import Findings
from hcss_twin.scene.ledger.entry import Skipped
from hcss_twin.scene.users_folder import of_the_same_folder, users_folder
from hcss_twin.version import __version__
from hcss_twin.versions import versions

_FORMAT = 1
"""Raised when what is written here changes its meaning."""


@dataclass(frozen=True)
class KeptFindings:
    """Findings, and the files that were read for them beside those the assembly had read.

    ``base`` is the folder of the scenario, if a user's files are among these.
    """

    findings: Findings
    file_names: tuple[str, ...]
    file_sha256: tuple[str, ...]
    base: str = ""


_CLASSES: Mapping[str, type] = {
    each.__name__: each for each in (KeptFindings, Findings, RequestedAccuracy, Skipped)
}


def kept_findings(scenario: Scenario, assembly: Assembly, catalog: Catalog) -> Findings | None:
    """Return what an earlier plan of the same scenario found; None if there is none, or a file has changed since.

    What that plan read is recorded again.
    """
    if isinstance(catalog, SecludedCatalog):
        return None
    store, key = Store(*PLANS), _key(scenario, assembly, catalog.used)
    path = store.find(key)
    if path is None:
        return None
    try:
        kept = read_record(path, _CLASSES)
        if isinstance(kept, KeptFindings):
            if not of_the_same_folder(catalog, kept.base):
                return None  # of a scenario elsewhere, with files of its own
            if catalog.unchanged(dict(zip(kept.file_names, kept.file_sha256, strict=True))):
                return kept.findings
    except Exception:  # whatever is wrong with the file, it is made again
        pass
    store.forget(key)
    return None


def keep_findings(
    scenario: Scenario, assembly: Assembly, catalog: Catalog, before: Mapping[str, str], findings: Findings
) -> None:
    """Keep what a plan found out.

    Parameters
    ----------
    before : mapping of str to str
        Files that were read before it was found out, with their hashes.
    """
    if isinstance(catalog, SecludedCatalog):
        return
    read = {name: digest for name, digest in catalog.used.items() if name not in before}
    new = KeptFindings(findings, tuple(read), tuple(read.values()), users_folder(catalog, read))
    Store(*PLANS).keep(_key(scenario, assembly, before), lambda draft: write_record(draft, new, _CLASSES))


def _key(scenario: Scenario, assembly: Assembly, files: Mapping[str, str]) -> str:
    """Hash of everything that the findings depend on."""
    # Most providers come from one package, whose many files are looked at once.
    fingerprint = cache(package_fingerprint)
    text = json.loads(scenario.to_json())
    parts = {
        "format": _FORMAT,
        "version": __version__,
        "libraries": versions(),
        "scenario": {name: value for name, value in text.items() if name != "title"},
        "filled_in": [dataclasses.asdict(each) for each in assembly.filled_in],
        "files": dict(files),
        "code": {
            kind: [
                entry.qualified_name,
                entry.version,
                fingerprint(top_level(entry.spec.target)),
            ]
            for kind, entry in assembly.entries.items()
        },
        "engine": fingerprint(__name__.partition(".")[0]),
    }
    return hashlib.sha256(json.dumps(parts, sort_keys=True, default=str).encode()).hexdigest()
