"""The catalog, at the import path of the provider API; defined in :mod:`hcss_twin.core.catalog`."""

from hcss_twin.core.catalog import Catalog

__all__ = ["Catalog"]
