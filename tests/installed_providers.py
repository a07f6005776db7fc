"""Providers of a test beside the built-in ones, as if a plugin with them were installed."""

from __future__ import annotations

import pytest

from hcss_twin.providers.registry import Origin, Registry


def install(patch: pytest.MonkeyPatch, plugin: object, name: str = "test") -> Registry:
    """Make the hooks of ``plugin``, of the package ``hcss-NAME``, those of the only one until the patch is undone."""
    registry = Registry.defaults_only()
    registry.add(plugin, Origin(name, f"hcss-{name}", "1.0"))
    assert not registry.broken
    patch.setattr(Registry, "discover", classmethod(lambda cls: registry))
    return registry
