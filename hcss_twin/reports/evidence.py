"""Evidence of a cube: what stands behind the numbers of its scene, from its attributes and the catalog of comparisons.

``catalogs/evidence.toml`` lists comparisons of the models with measurements, published values and other codes. A scene
has those whose words (``when``) are all among its own (:func:`tags_of`) and whose wavelengths lie in one of its bands.
A quantity is supported in a band by the share of the band's wavelengths that measurements cover; a comparison that the
model failed supports nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.core.own_packages import LIGHT, PROVIDERS
from hcss_twin.core.plugins import OWN_DISTRIBUTION
from hcss_twin.cube.header import SCENARIO_ATTRIBUTE
from hcss_twin.cube.reader import open_cube
from hcss_twin.cube.sensor_cube import SENSOR_ATTRIBUTE
from hcss_twin.reports.provenance import Provenance

FILE = "evidence.toml"

Kind = Literal["measurement", "published", "other code", "own code"]

KINDS: Mapping[Kind, str] = {
    "measurement": "measurement of nature",
    "published": "published values",
    "other code": "independent code",
    "own code": "consistency of own codes",
}
"""Kinds of references, the strongest first, with their names on pages."""

Limits = tuple[float, float]


@dataclass(frozen=True)
class Quantity:
    """Something that a scene has in every band, or as a whole.

    Attributes
    ----------
    name, title : str
    when : tuple of str
        Words that a scene must have, all of them.
    um : (float, float), optional
        Wavelengths at which it matters; default: any.
    by_band : bool
        Whether it is a radiance, which each band has for itself.
    """

    name: str
    title: str
    when: tuple[str, ...] = ()
    um: Limits | None = None
    by_band: bool = True


@dataclass(frozen=True)
class Comparison:
    """One comparison of a quantity with a reference; see ``catalogs/evidence.toml`` for the fields."""

    quantity: str
    reference: str
    kind: Kind
    blind: bool
    count: str
    condition: str
    figure: str
    source: str
    quote: str
    when: tuple[str, ...] = ()
    um: Limits | None = None
    failed: bool = False


@dataclass(frozen=True)
class Unmeasured:
    """Something of which nobody has measured how much it matters."""

    what: str
    source: str
    quote: str
    when: tuple[str, ...] = ()
    um: Limits | None = None


@dataclass(frozen=True)
class EvidenceCatalog:
    """All quantities, comparisons, and what is not measured."""

    quantities: tuple[Quantity, ...]
    comparisons: tuple[Comparison, ...]
    unmeasured: tuple[Unmeasured, ...]

    @classmethod
    def read(cls, path: Path | None = None) -> EvidenceCatalog:
        """Read the catalog.

        Raises
        ------
        CatalogError
            If a row has an unknown key, lacks one, or names an unknown quantity or kind of reference.
        """
        catalog = Catalog()
        path = path or catalog.find("evidence", "", ".toml")
        tables = catalog.toml(path)
        found = cls(
            tuple(_row(Quantity, path, row) for row in tables.get("quantity", [])),
            tuple(
                _row(Comparison, path, {"reference" if key == "with" else key: value for key, value in row.items()})
                for row in tables.get("comparison", [])
            ),
            tuple(_row(Unmeasured, path, row) for row in tables.get("unmeasured", [])),
        )
        known = {quantity.name for quantity in found.quantities}
        for comparison in found.comparisons:
            if comparison.quantity not in known:
                raise CatalogError(f"{path}: quantity '{comparison.quantity}'; allowed: {', '.join(sorted(known))}")
            if comparison.kind not in KINDS:
                raise CatalogError(f"{path}: kind '{comparison.kind}'; allowed: {', '.join(KINDS)}")
        return found


_Row = TypeVar("_Row", Quantity, Comparison, Unmeasured)


def _row(form: type[_Row], path: Path, row: Mapping[str, Any]) -> _Row:
    values: dict[str, Any] = {key: tuple(value) if isinstance(value, list) else value for key, value in row.items()}
    try:
        return form(**values)
    except TypeError as error:
        named = row.get("name", row.get("quantity", row.get("what", "")))
        raise CatalogError(f"{path}: {form.__name__.lower()} '{named}': {error}") from None


@dataclass(frozen=True)
class Support:
    """What supports a quantity of the scene in one band.

    Attributes
    ----------
    quantity : Quantity
    band : str
        Empty for quantities that do not depend on the band.
    measured : float
        Share of the band's wavelengths that measurements cover, 0 to 1, without those that the model failed.
    kinds : tuple of str
        Of the references of all comparisons that the model did not fail, the strongest first.
    failed : tuple of str
        Kinds of the references of those that it failed.
    """

    quantity: Quantity
    band: str
    measured: float
    kinds: tuple[Kind, ...]
    failed: tuple[Kind, ...]


@dataclass(frozen=True)
class Evidence:
    """What stands behind the numbers of a cube.

    Attributes
    ----------
    attributes : mapping
        Global attributes of the cube.
    bands_um : mapping of str to (float, float)
        Limits of each band.
    tags : frozenset of str
        Words of the scene.
    sun_zenith_deg : (float, float), optional
        Least and largest of the frames.
    catalog : EvidenceCatalog
    """

    attributes: Mapping[str, Any]
    bands_um: Mapping[str, Limits]
    tags: frozenset[str]
    sun_zenith_deg: Limits | None
    catalog: EvidenceCatalog

    @classmethod
    def of(cls, path: Path, catalog: EvidenceCatalog | None = None) -> Evidence:
        """Collect the evidence of a cube.

        Raises
        ------
        CubeError
            If it is not a complete cube.
        """
        with open_cube(path) as dataset:
            attributes = {str(name): value for name, value in dataset.attrs.items()}
            bands: dict[str, Limits] = {}
            if "wavelength_bounds" in dataset.coords:
                limits = np.atleast_2d(dataset["wavelength_bounds"].to_numpy()).astype(np.float64)
                names = np.atleast_1d(dataset["band"].to_numpy())
                bands = {str(name): (float(low), float(high)) for name, (low, high) in zip(names, limits, strict=True)}
            sun = None
            if "solar_zenith_angle" in dataset.coords:
                zenith = dataset["solar_zenith_angle"].to_numpy()
                sun = (float(np.nanmin(zenith)), float(np.nanmax(zenith)))
        return cls(attributes, bands, tags_of(attributes, sun), sun, catalog or EvidenceCatalog.read())

    def _applies(self, row: Quantity | Comparison | Unmeasured) -> bool:
        return self.tags.issuperset(row.when) and bool(self._bands_of(row.um) or not self.bands_um)

    def _bands_of(self, um: Limits | None) -> list[str]:
        """Return the bands that have any of the wavelengths."""
        return [band for band, (low, high) in self.bands_um.items() if um is None or (low < um[1] and um[0] < high)]

    @cached_property
    def quantities(self) -> tuple[Quantity, ...]:
        """Quantities that the scene has."""
        return tuple(quantity for quantity in self.catalog.quantities if self._applies(quantity))

    @cached_property
    def comparisons(self) -> tuple[Comparison, ...]:
        """Comparisons of the scene's quantities, in the order of the quantities and strongest kinds first."""
        order = {quantity.name: index for index, quantity in enumerate(self.quantities)}
        fitting = [row for row in self.catalog.comparisons if row.quantity in order and self._applies(row)]
        return tuple(sorted(fitting, key=lambda row: (order[row.quantity], list(KINDS).index(row.kind))))

    @cached_property
    def unmeasured(self) -> tuple[Unmeasured, ...]:
        """What is not measured of the scene."""
        return tuple(row for row in self.catalog.unmeasured if self._applies(row))

    @cached_property
    def support(self) -> tuple[Support, ...]:
        """What supports each quantity in each band in which it matters."""
        found = []
        for quantity in self.quantities:
            rows = [row for row in self.comparisons if row.quantity == quantity.name]
            for band in self._bands_of(quantity.um) if quantity.by_band else [""]:
                here = [row for row in rows if not band or band in self._bands_of(row.um)]
                kinds, failed = (
                    tuple(kind for kind in KINDS if any(row.kind == kind and row.failed is fails for row in here))
                    for fails in (False, True)
                )
                measured = [row.um for row in here if row.kind == "measurement" and not row.failed]
                whole = self.bands_um.get(band) if band else None
                share = float(bool(measured)) if whole is None else _covered(whole, measured)
                found.append(Support(quantity, band, share, kinds, failed))
        return tuple(found)

    @property
    def unsupported(self) -> tuple[Support, ...]:
        """Quantities and bands that no measurement supports."""
        return tuple(row for row in self.support if row.measured == 0.0)

    @property
    def budget(self) -> list[dict[str, Any]]:
        """Errors of all models by class and band, the largest first; unknown ones last."""
        rows = []
        for of, bands in Provenance.value(self.attributes, "hcss_error_budget", {}).items():
            for band, cell in bands.items():
                named = "at_least" if "at_least" in cell else "total"
                total = {"model": "total", "relative": cell[named], "kelvin": cell[f"{named}_K"], "known": 1.0}
                parts = [
                    {"model": part["name"], **{key: part[key] for key in ("relative", "kelvin", "known", "statistic")},
                     "references": _references(part), "recomputed": part["recomputed"]}
                    for part in sorted(cell["contributions"], key=lambda part: -(part["relative"] or 0.0))
                ]  # fmt: skip
                rows += [
                    {"class": of, "band": band, **part}
                    for part in (
                        {**total, "statistic": "at least" if cell["unknown"] else "root of sum of squares",
                         "references": [], "recomputed": True},
                        *parts,
                    )
                ]  # fmt: skip
        return rows

    def as_dict(self) -> dict[str, Any]:
        """Return everything as JSON values."""
        name = {quantity.name: quantity.title for quantity in self.quantities}
        certificate = {
            key.removeprefix("hcss_"): self.attributes[key]
            for key in ("hcss_certificate", "hcss_certificate_pixels", "hcss_accuracy_requested")
            if key in self.attributes
        }
        certificate = {key: value.item() if hasattr(value, "item") else value for key, value in certificate.items()}
        return {
            "title": str(self.attributes.get("title", "")),
            "bands_um": {band: list(limits) for band, limits in self.bands_um.items()},
            "scene": sorted(self.tags),
            "certificate": {
                **certificate, "largest_error": Provenance.value(self.attributes, "hcss_accuracy_achieved", {}),
            },
            "budget": self.budget,
            "comparisons": [{**asdict(row), "quantity": name[row.quantity]} for row in self.comparisons],
            "support": [
                {"quantity": row.quantity.title, "band": row.band, "measured_share": row.measured, "kinds": row.kinds,
                 "failed": row.failed}
                for row in self.support
            ],
            "no_measurement": [{"quantity": row.quantity.title, "band": row.band} for row in self.unsupported],
            "unmeasured": [asdict(row) for row in self.unmeasured],
        }  # fmt: skip


def _references(part: Mapping[str, Any]) -> list[str]:
    """Return what a contribution was measured against."""
    own = {"engine": "certificate of this cube", "numerics": "finer levels of the same model, by the plan"}
    return list(part["sources"]) or ([own[part["name"]]] if part["name"] in own else [])


def _covered(whole: Limits, parts: Iterable[Limits | None]) -> float:
    """Return the share of an interval that others cover together."""
    end, covered = whole[0], 0.0
    for low, high in sorted(whole if part is None else part for part in parts):
        start, stop = max(low, end), min(high, whole[1])
        covered += max(stop - start, 0.0)
        end = max(end, stop)
    return covered / (whole[1] - whole[0])


def tags_of(attributes: Mapping[str, Any], sun_zenith_deg: Limits | None) -> frozenset[str]:
    """Return the words of a scene, by which rows of the catalog are selected.

    They are ``clear``, ``cloud``, ``water`` and ``ice`` (of clouds), ``sea``, ``land``, ``day``, ``night``,
    ``elements``, ``sensor``, ``columns`` or ``sides`` (of clouds), ``inversion`` or ``no inversion``, ``aerosol``,
    ``vapour texture``, ``rrtmgp`` or ``lowtran7`` (coefficients), ``type NAME`` of each cloud, and the names of all
    providers.

    Parameters
    ----------
    attributes : mapping
        Global attributes of the cube.
    sun_zenith_deg : (float, float), optional
        Least and largest of the frames.
    """
    scenario = Provenance.value(attributes, SCENARIO_ATTRIBUTE, {})
    air = scenario.get("atmosphere") or {}
    aerosol = (air.get("parameters") or {}).get("aerosol", "maritime")  # the default of band-model
    layers = (scenario.get("clouds") or {}).get("layers") or []
    types = {str(layer["type"]) for layer in layers if layer.get("coverage") != 0.0}
    absent = {str(layer["type"]) for layer in layers} - types
    particles = [each for each in Provenance.value(attributes, "hcss_particles", []) if each["name"] not in absent]
    budget = Provenance.value(attributes, "hcss_error_budget", {})
    tags = {"sea", *_providers(attributes)}
    tags |= {str(layer["material"]) for layer in particles if "material" in layer}
    tags |= {f"type {each}" for each in types}
    if particles:
        tags |= {"cloud", "sides" if "hcss_light" in attributes else "columns"}
    if "clear" in budget or not budget:
        tags.add("clear")
    if sun_zenith_deg is not None:
        tags |= {"day"} if sun_zenith_deg[0] < 90.0 else set()
        tags |= {"night"} if sun_zenith_deg[1] >= 90.0 else set()
    if "coefficients" in air:
        tags.add(str(air["coefficients"]))
    given = {
        "land": scenario.get("surfaces") is not None,
        "elements": bool(scenario.get("elements")),
        "sensor": SENSOR_ATTRIBUTE in attributes,
        "aerosol": aerosol != "none",
        "vapour texture": air.get("water_vapour_texture") != 0.0,
        "inversion": air.get("inversion") != "off",
        "no inversion": air.get("inversion") == "off",
    }
    return frozenset(tags | {tag for tag, holds in given.items() if holds})


def _providers(attributes: Mapping[str, Any]) -> set[str]:
    """Return the names of providers of packages of this repository: those of others may have the same names."""
    own = {OWN_DISTRIBUTION, *PROVIDERS.values(), *LIGHT.values()}
    providers = Provenance.value(attributes, "hcss_providers", {}).values()
    return {str(each.get("name")) for each in providers if each.get("distribution") in own}
