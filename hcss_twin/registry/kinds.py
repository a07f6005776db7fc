"""The kinds of provider that an installed package can bring."""

from __future__ import annotations

from enum import StrEnum


class Kind(StrEnum):
    """One swappable kind.

    Attributes
    ----------
    hook : str
        Name of the hook through which providers of this kind are registered.
    human : str
        What people call it, for messages.
    protocol : str
        Name of its Protocol in ``hcss_twin.providers``.
    """

    hook: str
    human: str
    protocol: str

    CLOUDS = "clouds", "hcss_register_cloud_generators", "cloud generator", "CloudGenerator"
    SEA = "sea", "hcss_register_sea_models", "sea model", "SeaModel"
    OPTICS = "optics", "hcss_register_optics", "optics provider", "Optics"
    ATMOSPHERE = (
        "atmosphere",
        "hcss_register_transmittance_providers",
        "transmittance provider",
        "TransmittanceProvider",
    )
    RADIANCE = "radiance", "hcss_register_radiance_models", "radiance model", "RadianceModel"
    SENSORS = "sensors", "hcss_register_sensors", "sensor model", "Sensor"

    def __new__(cls, value: str, hook: str = "", human: str = "", protocol: str = "") -> Kind:
        """Make a member that is the string ``value`` and carries the other three."""
        member = str.__new__(cls, value)
        member._value_ = value
        member.hook = hook
        member.human = human
        member.protocol = protocol
        return member
