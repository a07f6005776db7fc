"""The catalog and the door to NetCDF files, at the import path of the provider API; defined in ``hcss_twin.core``."""

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.netcdf import NetcdfFile

__all__ = ["Catalog", "NetcdfFile"]
