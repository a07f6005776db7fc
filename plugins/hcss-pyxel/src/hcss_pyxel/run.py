"""A whole run of Pyxel, kept in one file."""

from __future__ import annotations

from pathlib import Path

from hcss_twin.drafts import draft_of
from hcss_twin.errors import CubeError


def run_pipeline(pipeline: Path, output: Path) -> dict[str, float]:
    """Run a pipeline and write what its detector held after each step as NetCDF.

    Parameters
    ----------
    pipeline : Path
        YAML file of Pyxel in exposure mode.
    output : Path

    Returns
    -------
    dict
        Mean of each variable.

    Raises
    ------
    CubeError
        If the file cannot be written.
    """
    import pyxel

    result = pyxel.run_mode(pyxel.load(pipeline))
    held = result["bucket"].to_dataset()
    with draft_of(output, CubeError) as draft:
        held.to_netcdf(draft, engine="netcdf4")
    return {
        f"{name} ({data.attrs.get('units', '')})": float(data.mean()) for name, data in held.data_vars.items()
    }
