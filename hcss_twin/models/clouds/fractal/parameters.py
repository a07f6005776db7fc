"""Parameters of the fractal cloud generator (eqs 2-4 and Table III of the HCSS paper)."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator

__all__ = ["FractalParameters"]


def _pair(value: Any) -> Any:
    """Accept a list as a pair: configuration files have no tuples."""
    return tuple(value) if isinstance(value, list) else value


_Cells = Annotated[float, Field(ge=1e-3, le=1e6, allow_inf_nan=False)]
_Octave = Annotated[int, Field(ge=0, le=16)]


class FractalParameters(BaseModel):
    """Shape of the multiscale sum; missing values are those of the cloud type."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    gamma: float | None = Field(
        default=None,
        ge=1.01,
        le=8.0,
        allow_inf_nan=False,
        description="Gap parameter: each octave has gamma times the cells of the one before it (r in Table III).",
    )
    H: float | None = Field(
        default=None,
        gt=0.0,
        lt=1.0,
        allow_inf_nan=False,
        description="Hurst exponent: octave k has the amplitude gamma^(-k H); larger is smoother.",
    )
    L: Annotated[tuple[_Cells, _Cells] | None, BeforeValidator(_pair)] = Field(
        default=None, description="Lattice cells per 16 km (800 pixels of 20 m) along x and y at k = 0."
    )
    k: Annotated[tuple[_Octave, _Octave] | None, BeforeValidator(_pair)] = Field(
        default=None, description="First and last octave, 0 <= k0 <= kmax <= 16."
    )
    brightness_exponent: float = Field(
        default=1.0,
        ge=0.05,
        le=20.0,
        allow_inf_nan=False,
        description="s in C = p_c^s, with p_c from 0 at the edge of the cloudy area to 1 at its peak: "
        "above 1 most of the cloud is thin; 1 is eq 7 as printed.",
    )

    @field_validator("k")
    @classmethod
    def _ascending(cls, value: tuple[int, int] | None) -> tuple[int, int] | None:
        if value is not None and value[0] > value[1]:
            raise ValueError(
                f"k0 = {value[0]} is greater than kmax = {value[1]}; allowed: k0 <= kmax, "
                f"closest is [{value[1]}, {value[0]}]"
            )
        return value
