"""Check of units against the part of the UDUNITS database that derived variables of a scene can have."""

from __future__ import annotations

import re

_SYMBOLS = frozenset((
    "1", "m", "g", "s", "K", "A", "mol", "cd", "rad", "sr", "Hz", "N", "Pa", "J", "W", "C", "V", "ohm", "T", "bar",
    "h", "min", "d", "L", "l", "eV", "arc_degree", "degC", "Celsius", "um", "%", "percent", "ppm"
))  # fmt: skip
_WORDS = frozenset((
    "meter", "metre", "gram", "second", "kelvin", "mole", "radian", "steradian", "hertz", "newton", "pascal",
    "joule", "watt", "coulomb", "volt", "hour", "minute", "day", "degree", "micron", "liter", "litre",
    "degree_north", "degrees_north", "degree_east", "degrees_east", "degree_C", "count"
))  # fmt: skip
_PREFIXES = re.compile("(?:da|[YZEPTGMkhdcmunpfazy])(?=.)")
_LONG_PREFIXES = re.compile("(?:giga|mega|kilo|hecto|deci|centi|milli|micro|nano|pico)(?=.)")
_FACTOR = re.compile(r"(?P<name>%|1|[A-Za-z_]+)(?:(?:\^|\*\*)?(?P<power>[+-]?\d+))?")
_SCALE = re.compile(r"[+-]?\d+(?:\.\d*)?(?:[eE][+-]?\d+)? (?=\S)")


def units_problem(text: str) -> str:
    """Return what is wrong with units, such as ``W m-2 sr-1``; empty if nothing is.

    A product of powers, divided by "/", of the usual units with decimal prefixes; "1" for a number without dimension.
    """
    rest = _SCALE.sub("", text, count=1)
    for factor in re.split(r"\s*/\s*|\s*\.\s*|(?<!\*)\*(?!\*)|\s+", rest):
        found = _FACTOR.fullmatch(factor)
        if found is None:
            return f"'{text}': '{factor}' is no power of a unit, such as m-2"
        if not _is_known(found["name"]):
            return f"'{text}': '{found['name']}' is no unit of UDUNITS that this kit knows"
    return ""


def _is_known(name: str) -> bool:
    singular = name[:-1] if name.endswith("s") else name
    return (
        name in _SYMBOLS
        or _PREFIXES.sub("", name, count=1) in _SYMBOLS - {"1", "%"}
        or bool({name, singular} & _WORDS)
        or bool({_LONG_PREFIXES.sub("", each, count=1) for each in (name, singular)} & _WORDS)
    )
