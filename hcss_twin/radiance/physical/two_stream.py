"""Radiance model ``physical-two-stream``: the laws of ``physical`` with clouds in closed form."""

from __future__ import annotations

from hcss_twin.radiance.physical.model import Physical


class PhysicalTwoStream(Physical):
    """As :class:`Physical`, with each cloud layer by a delta-Eddington two-stream solution and exact single scattering.

    Energy is conserved and an isothermal enclosure is black all the same. Errors of single layers against discrete
    ordinates are in docs/multiple-scattering.md: emissivity by some 0.02, reflected sunlight by some 15 percent.
    """

    closed_form = True
