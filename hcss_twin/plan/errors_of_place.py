"""How far air, sea and low clouds of a place by climatology are from measured images.

A climatology knows no weather. The figures are standard deviations and means, added in quadrature, over boxes of 2
degrees of a SEVIRI image (6 September 2020, 00:45 UTC, Atlantic and Mediterranean, view zenith 17 to 65 degrees): 14 of
clear sea, and 10 of opaque low cloud. The split of clear sea between water and air is that of fits to 10.8 and 12.0 um.
They were chosen so that the total of a scene covers these boxes (``COMMAND`` prints the share); no other day was used.
"""

from __future__ import annotations

from hcss_twin.providers import ModelError

COMMAND = "python benchmarks/seviri_boxes.py"
_IMAGE = "SEVIRI, 6 September 2020"


def _clear(name: str, lower_um: float, upper_um: float, kelvin: float) -> ModelError:
    return ModelError(
        name=name,
        lower_um=lower_um,
        upper_um=upper_um,
        kelvin=kelvin,
        condition="clear sea, 14 boxes",
        source=_IMAGE,
        command=COMMAND,
        column="clear",
    )


SEA_BY_CLIMATOLOGY = (
    _clear("sea temperature by climatology", 2.5, 12.9, 1.05),
    _clear("sea temperature by climatology", 12.9, 14.0, 0.5),
)
AIR_BY_CLIMATOLOGY = (_clear("air by climatology", 2.5, 5.0, 0.5), _clear("air by climatology", 7.0, 14.0, 0.5))


def _low_cloud(layer: str, lower_um: float, upper_um: float, kelvin: float) -> ModelError:
    return ModelError(
        name="altitude of low cloud by place",
        lower_um=lower_um,
        upper_um=upper_um,
        kelvin=kelvin,
        condition="opaque low cloud, 10 boxes",
        source=_IMAGE,
        command=COMMAND,
        column=layer,
    )


def tops_by_place(layer: str) -> tuple[ModelError, ...]:
    """Return the error of a layer whose top lies at the inversion of the place: 500 m of altitude."""
    return _low_cloud(layer, 2.5, 12.9, 3.0), _low_cloud(layer, 12.9, 14.0, 2.0)
