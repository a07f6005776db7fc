"""What a package says about a provider before anything of it is imported."""

from __future__ import annotations

import re
from dataclasses import dataclass

API_VERSION = 1
"""Version of the provider contract this engine speaks; the same number as ``providers.API_VERSION``."""

_NAME = re.compile(r"[a-z0-9][a-z0-9-]*")
_TARGET = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*", re.ASCII)


@dataclass(frozen=True)
class ProviderSpec:
    """Name and whereabouts of one provider.

    Attributes
    ----------
    name : str
        What a scenario writes to select it: lower-case letters, digits and hyphens.
    target : str
        ``"package.module:Class"``; imported only when a scenario selects the provider.
    parameters : str or None
        ``"package.module:Model"`` of its pydantic parameter model, as lazy as ``target``; None where
        the provider accepts no parameters.
    api_version : int
        Version of the provider contract it was written for, as a literal number.
    summary : str
        One line for ``hcss plugins``.
    references : tuple of str
        Where the model comes from.

    Raises
    ------
    ValueError
        If a field is malformed.
    """

    name: str
    target: str
    parameters: str | None
    api_version: int
    summary: str
    references: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not _NAME.fullmatch(self.name):
            raise ValueError(
                f"name {self.name!r}: allowed are lower-case letters, digits, and hyphens within"
            )
        _check_target("target", self.name, self.target)
        if self.parameters is not None:
            _check_target("parameters", self.name, self.parameters)
        if (
            not isinstance(self.api_version, int)
            or isinstance(self.api_version, bool)
            or self.api_version < 0
        ):
            raise ValueError(f"api_version {self.api_version!r} of '{self.name}': must be a whole number")
        if not isinstance(self.summary, str) or not self.summary.strip() or "\n" in self.summary:
            raise ValueError(f"summary {self.summary!r} of '{self.name}': must be one line of text")
        references = self.references
        if not isinstance(references, tuple) or not all(isinstance(each, str) for each in references):
            raise ValueError(f"references {references!r} of '{self.name}': must be a tuple of strings")


def _check_target(field: str, name: str, value: object) -> None:
    if not isinstance(value, str) or not _TARGET.fullmatch(value):
        raise ValueError(f"{field} {value!r} of '{name}': must look like 'package.module:Class'")
