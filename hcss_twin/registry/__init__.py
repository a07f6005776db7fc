"""Specs and hooks, at the import path that the provider API promises; see :mod:`hcss_twin.providers.registry`."""

from hcss_twin.providers.registry import API_VERSION, Kind, ProviderSpec, hookimpl

__all__ = ["API_VERSION", "Kind", "ProviderSpec", "hookimpl"]
