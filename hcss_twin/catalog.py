"""The catalog, at the import path that the provider API promises; defined in :mod:`hcss_twin.core.catalog`."""

from hcss_twin.core.catalog import Catalog

__all__ = ["Catalog"]
