"""Small providers, one of each kind: written from the guide alone, they show that it works."""

from hcss_twin.providers import ProviderSpec, hookimpl


def _spec(name, target, summary):
    module = target.partition(":")[0]
    return [ProviderSpec(name, f"stranger.{target}", f"stranger.{module}:Parameters", 3, summary)]


@hookimpl
def hcss_register_cloud_generators():
    return _spec("streets", "clouds:CloudStreets", "parallel rolls of cloud, thick in the middle")


@hookimpl
def hcss_register_sea_models():
    return _spec("slush", "sea:Slush", "grains that scatter once (Lommel and Seeliger)")


@hookimpl
def hcss_register_optics():
    return _spec("soft", "optics:SoftParticles", "anomalous diffraction with one refractive index")


@hookimpl
def hcss_register_transmittance_providers():
    return _spec("malkmus", "atmosphere:Malkmus", "one band of lines that saturate")


@hookimpl
def hcss_register_radiance_models():
    return _spec("absorbing", "radiance:Absorbing", "clouds that only absorb and emit")


@hookimpl
def hcss_register_elements():
    return _spec("ship", "elements:Ship", "a warm square that hides the sea")


@hookimpl
def hcss_register_surfaces():
    return _spec("floe", "surfaces:Floe", "ice whose temperature falls toward the north")


@hookimpl
def hcss_register_variables():
    return _spec("slant", "variables:Slant", "path in cloud and angle from the glint")


@hookimpl
def hcss_register_sensors():
    return _spec("lagging", "sensor:Lagging", "detectors that keep a part of the last frame")
