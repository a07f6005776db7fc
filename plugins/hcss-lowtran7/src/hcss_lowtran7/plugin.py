"""Hook that registers the provider. It is imported at every start, so it must import quickly."""

from hcss_twin.providers import ProviderSpec, hookimpl


@hookimpl
def hcss_register_transmittance_providers() -> list[ProviderSpec]:
    """Register the provider `lowtran7`."""
    return [
        ProviderSpec(
            name="lowtran7",
            target="hcss_lowtran7.provider:Lowtran7",
            parameters="hcss_lowtran7.parameters:Lowtran7Parameters",
            api_version=3,
            summary="LOWTRAN7, the original Fortran: band model of 20 cm-1, aerosols; needs gfortran",
            references=("Kneizys et al., Users Guide to LOWTRAN 7, AFGL-TR-88-0177 (1988)",),
        )
    ]
