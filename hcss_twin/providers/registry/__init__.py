"""Discovery of providers: hook specifications, provider specs, isolation of broken plugins."""

from hcss_twin.core.plugins import BrokenPlugin, Origin
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.providers.registry.specs import API_VERSION, Kind, ProviderSpec, hookimpl

__all__ = ["API_VERSION", "BrokenPlugin", "Entry", "Kind", "Origin", "ProviderSpec", "Registry", "hookimpl"]
