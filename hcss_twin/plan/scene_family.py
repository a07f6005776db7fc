"""Families of scenes: what a package that computes many scenes, alike but for one input, brings to share columns."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Protocol, TypeVar

from hcss_twin.providers import ColumnSetting, RadianceModel, SeaModel

Kept = TypeVar("Kept")


class SceneFamily(Protocol):
    """Scenes that differ in one input, and in what radiance does not depend on.

    Attributes
    ----------
    key : str
        What columns of its scenes depend on beyond the scene, for keys of kept results.
    """

    @property
    def key(self) -> str:
        """As above."""
        ...

    def sharing(
        self, model: RadianceModel, level: tuple[int, int], setting: ColumnSetting, sea_of: Callable[[float], SeaModel]
    ) -> RadianceModel:
        """Return a model that shares columns with the models of the other scenes.

        Parameters
        ----------
        level : (int, int)
            Numerical level, and how many levels finer sunlight is.
        setting : ColumnSetting
            Of the scene, at night.
        sea_of : callable
            Builds its sea for another temperature.
        """
        ...

    def spanning(self, setting: ColumnSetting, sea_of: Callable[[float], SeaModel]) -> list[ColumnSetting]:
        """Return settings that span the family, the same for all its scenes: their wavenumbers serve all of them."""
        ...

    def keep(self, name: Hashable, compute: Callable[[], Kept]) -> Kept:
        """Return what all scenes of the family have in common, computed by the first of this process."""
        ...
