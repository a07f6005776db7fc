"""Discovery of providers: hook specifications, provider specs, isolation of broken plugins."""

from hcss_twin.registry.discovery import BrokenPlugin, Entry, Origin
from hcss_twin.registry.hookspecs import hookimpl
from hcss_twin.registry.kinds import Kind
from hcss_twin.registry.registry import Registry
from hcss_twin.registry.specs import API_VERSION, ProviderSpec

__all__ = ["API_VERSION", "BrokenPlugin", "Entry", "Kind", "Origin", "ProviderSpec", "Registry", "hookimpl"]
