"""A pass in a file: camera, orbit, attitude and jitter as TOML."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from datetime import datetime
from pathlib import Path
from typing import Any

from hcss_payload.attitude import Attitude, Nadir, PushBroom, Track
from hcss_payload.camera import Camera
from hcss_payload.ccsds import read_aem, read_oem
from hcss_payload.checks import PayloadError
from hcss_payload.jitter import Jitter
from hcss_payload.trajectory import Circular, Geostationary, Trajectory, TwoLineElements
from hcss_twin.core.errors import choose_from

_SECTIONS = ("camera", "orbit", "attitude", "jitter")


@dataclass(frozen=True)
class PassFile:
    """What a file says about a pass."""

    camera: Camera
    trajectory: Trajectory
    attitude: Attitude
    jitter: Jitter | None


def read_pass(path: str | Path, start: datetime) -> PassFile:
    """Read the sections ``[camera]``, ``[orbit]``, ``[attitude]`` and, optionally, ``[jitter]`` of a TOML file.

    Keys are the parameters of the classes of this package; ``type`` chooses the orbit (``circular``,
    ``geostationary``, ``tle``, ``oem``) and the attitude (``nadir``, ``track``, ``push-broom``, ``aem``), and ``file``
    names a CCSDS message, relative to the TOML file.

    Parameters
    ----------
    start : datetime
        Time 0 of two-line elements and messages, in UTC.

    Raises
    ------
    PayloadError
        Names the file and the key.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
        content = tomllib.loads(text)
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise PayloadError(f"{path}: {error}; allowed: a TOML file with {_named(_SECTIONS)}") from error
    for name in content:
        if name not in _SECTIONS:
            raise PayloadError(f"{path}: [{name}]; {choose_from(name, _SECTIONS)}")
    for name in _SECTIONS[:3]:
        if not isinstance(content.get(name), dict):
            raise PayloadError(f"{path}: no section [{name}]; allowed: {_named(_SECTIONS)}, the last one optional")

    def file(given: Mapping[str, Any], key: str) -> Path:
        return path.parent / str(given[key])

    orbits: dict[str, tuple[tuple[str, ...], Callable[[dict[str, Any]], Trajectory]]] = {
        "circular": (_keys(Circular), lambda given: Circular(**given)),
        "geostationary": (_keys(Geostationary), lambda given: Geostationary(**given)),
        "tle": (("line1", "line2"), lambda given: TwoLineElements(**given, start=start)),
        "oem": (("file",), lambda given: read_oem(file(given, "file"), start)),
    }
    trajectory: Trajectory = _chosen(path, "orbit", content["orbit"], orbits)
    attitudes: dict[str, tuple[tuple[str, ...], Callable[[dict[str, Any]], Attitude]]] = {
        "nadir": ((), lambda given: Nadir(trajectory)),
        "track": (_keys(Track)[1:], lambda given: Track(trajectory, **given)),
        "push-broom": (_keys(PushBroom)[1:], lambda given: PushBroom(trajectory, **given)),
        "aem": (("file",), lambda given: read_aem(file(given, "file"), start)),
    }
    attitude: Attitude = _chosen(path, "attitude", content["attitude"], attitudes)
    camera: Camera = _built(path, "camera", content["camera"], _keys(Camera), lambda given: Camera(**given))
    jitter: Jitter | None = None
    if "jitter" in content:
        allowed = tuple(name for name in _keys(Jitter) if name != "lines")
        jitter = _built(path, "jitter", content["jitter"], allowed, lambda given: Jitter(**given))
    return PassFile(camera, trajectory, attitude, jitter)


def _keys(kind: type[Any]) -> tuple[str, ...]:
    return tuple(each.name for each in fields(kind))


def _named(names: tuple[str, ...]) -> str:
    return ", ".join(f"[{name}]" for name in names)


def _chosen(path: Path, name: str, section: Mapping[str, Any], known: Mapping[str, Any]) -> Any:
    given = dict(section)
    kind = given.pop("type", None)
    if kind not in known:
        raise PayloadError(f"{path}: {name}.type: {kind!r}; {choose_from(str(kind), tuple(known))}")
    allowed, build = known[kind]
    return _built(path, name, given, allowed, build)


def _built(
    path: Path, name: str, given: Mapping[str, Any], allowed: tuple[str, ...], build: Callable[[dict[str, Any]], Any]
) -> Any:
    for key in given:
        if key not in allowed:
            choice = choose_from(key, allowed) if allowed else "allowed: no keys"
            raise PayloadError(f"{path}: {name}.{key}; {choice}")
    try:
        return build({key: tuple(value) if isinstance(value, list) else value for key, value in given.items()})
    except PayloadError as error:
        raise PayloadError(f"{path}: {error}") from error
    except (TypeError, KeyError) as error:  # missing keys and values of another type
        raise PayloadError(f"{path}: [{name}]: {error}; allowed keys: {', '.join(allowed)}") from error
