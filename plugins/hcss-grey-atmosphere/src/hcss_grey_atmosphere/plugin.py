"""Hook that registers the provider. It is imported at every start, so it must import quickly."""

from hcss_twin.providers import ProviderSpec, hookimpl


@hookimpl
def hcss_register_transmittance_providers() -> list[ProviderSpec]:
    """Register the provider `grey`."""
    return [
        ProviderSpec(
            name="grey",
            target="hcss_grey_atmosphere.provider:GreyAtmosphere",
            parameters="hcss_grey_atmosphere.parameters:GreyParameters",
            api_version=3,
            summary="grey, well-mixed gas: T = exp(-optical depth x air mass)",
        )
    ]
