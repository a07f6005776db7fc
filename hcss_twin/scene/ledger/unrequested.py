"""Outputs that nobody asked for."""

from __future__ import annotations

from collections.abc import Iterator

from hcss_twin.cube.variables import TERM_PREFIX, VariableSpec
from hcss_twin.scene.ledger.entry import Skipped


def unrequested(
    requested: tuple[VariableSpec, ...], possible: tuple[VariableSpec, ...], certificate: bool
) -> Iterator[Skipped]:
    """Yield what the scene could have given beside what it was asked for.

    Parameters
    ----------
    requested, possible : tuple of VariableSpec
        Of the cube, and all that the scene has.
    certificate : bool
        Whether pixels are to be checked.
    """
    names = {spec.name for spec in requested}
    left = [spec for spec in possible if spec.name not in names]
    radiance = any(spec.needs_radiance for spec in requested)
    if not radiance:
        yield Skipped("all radiance", "no requested variable needs it", 0.0)
    elif not certificate:
        yield Skipped("the certificate", "output.certificate is 0: no pixel is checked", 0.0)
    terms = [spec.name for spec in left if spec.name.startswith(TERM_PREFIX)] if radiance else []
    if terms:
        yield Skipped(
            "look-up of terms of the radiance",
            f"not requested; the total has all: {', '.join(name.removeprefix(TERM_PREFIX) for name in terms)}",
            0.0,
        )
    others = [spec.name for spec in left if spec.kind == "truth" or (radiance and spec.kind == "derived")]
    if others:
        yield Skipped("other variables", f"not requested: {', '.join(others)}", 0.0)
