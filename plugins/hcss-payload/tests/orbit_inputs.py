"""Two-line elements and orbit ephemeris messages: 100 that must be read, with the positions they mean, and bad ones.

Positions come from SGP4 (package sgp4) and sidereal time from ERFA, and never from the readers that are judged. Every
input is determined by its number.
"""

import math
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from functools import lru_cache

import numpy as np
from payload_scenes import with_checksum

START = datetime(2024, 4, 20, 2, 30, tzinfo=UTC)
FRAMES_S = (0.0, 30.0, 60.0)
RATE = 7.292115e-5

# inclination deg, eccentricity, revolutions a day
ORBITS = {
    "station": (51.64, 0.0006, 15.5),
    "polar": (98.2, 0.0001, 14.571),
    "low": (97.4, 0.001, 15.2),
    "high-polar": (66.0, 0.0008, 12.8),
    "navigation": (55.0, 0.004, 2.00565),
    "geostationary": (0.05, 0.0002, 1.0027),
    "eccentric": (63.4, 0.7, 2.00612),
}
LOW = ("station", "polar", "low", "high-polar")


@dataclass(frozen=True)
class OrbitInput:
    """An input, what it means, and what an answer must name.

    ``orbit`` has the keys of the section; ``content`` the bytes of the file; ``expected_m`` positions at FRAMES_S with
    the allowed error ``within_m``; ``names`` a regular expression of what a refusal or note must contain.
    """

    name: str
    orbit: dict
    content: bytes | None = None
    expected_m: list | None = None
    within_m: float = 20.0
    names: str = ""
    place: tuple | None = None
    start: datetime = START
    more: dict = field(default_factory=dict)


def elements(orbit="polar", age_days=1.0, number="39084", seed=0, start=START, **changes):
    """Two lines of an orbit whose epoch is some days before the start."""
    rng = np.random.default_rng([seed, 40])
    inclination, eccentricity, motion = ORBITS[orbit]
    epoch = start - timedelta(days=age_days)
    day = (epoch - datetime(epoch.year, 1, 1, tzinfo=UTC)).total_seconds() / 86400.0 + 1.0
    node, argument, anomaly = rng.uniform(0.0, 360.0, 3)
    value = {
        "day": f"{epoch.year % 100:02d}{day:012.8f}", "kind": "U", "drag": " 12000-4", "ndot": " .00000500",
        "inclination": f"{inclination:8.4f}", "node": f"{node:8.4f}", "eccentricity": f"{eccentricity * 1e7:07.0f}",
        "argument": f"{argument:8.4f}", "anomaly": f"{anomaly:8.4f}", "motion": f"{motion:11.8f}", "set": " 999",
    } | changes  # fmt: skip
    start_of_first = f"1 {number:>5}{value['kind']} 13008A   {value['day']}"
    first = f"{start_of_first} {value['ndot']}  00000-0 {value['drag']} 0 {value['set']}0"
    second = (
        f"2 {number:>5} {value['inclination']} {value['node']} {value['eccentricity']} {value['argument']} "
        f"{value['anomaly']} {value['motion']}59500"
    )
    return with_checksum(f"{first[:68]:68}"), with_checksum(f"{second[:63]:63}59500")


def teme(lines, moment):
    """Position and velocity (m, m/s) of TEME at a moment."""
    from sgp4.api import Satrec, jday

    second = moment.second + moment.microsecond * 1e-6
    code, position, velocity = Satrec.twoline2rv(*lines).sgp4(
        *jday(moment.year, moment.month, moment.day, moment.hour, moment.minute, second)
    )
    assert code == 0, (code, lines)
    return 1e3 * np.array(position), 1e3 * np.array(velocity)


def sidereal(moment):
    import erfa

    whole = (datetime(moment.year, moment.month, moment.day, tzinfo=UTC) - datetime(2000, 1, 1, 12, tzinfo=UTC)).days
    part = (moment - datetime(moment.year, moment.month, moment.day, tzinfo=UTC)).total_seconds() / 86400.0
    return float(erfa.gmst82(2451545.0 + whole + 0.5, part))


def turned(vector, angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * vector[0] + s * vector[1], c * vector[1] - s * vector[0], vector[2]])


@lru_cache(maxsize=100_000)
def earth_fixed(lines, moment):
    """Position and velocity (m, m/s) over the rotating Earth, with UT1 = UTC and the pole at 0."""
    position, velocity = teme(lines, moment)
    angle = sidereal(moment)
    fixed = turned(position, angle)
    return fixed, turned(velocity, angle) - np.cross([0.0, 0.0, RATE], fixed)


def below(lines, start=START, time_s=30.0):
    """Latitude and longitude of the sphere below a satellite, deg."""
    position, _ = earth_fixed(lines, start + timedelta(seconds=time_s))
    latitude = math.degrees(math.asin(position[2] / np.linalg.norm(position)))
    return round(latitude, 3), round(math.degrees(math.atan2(position[1], position[0])), 3)


def positions(lines, start=START):
    return [earth_fixed(lines, start + timedelta(seconds=frame_s))[0].tolist() for frame_s in FRAMES_S]


def stamp(moment, form="plain"):
    match form:
        case "day":
            return moment.strftime("%Y-%jT%H:%M:%S.%f")
        case "z":
            return moment.strftime("%Y-%m-%dT%H:%M:%S.%fZ")
        case "whole":
            return moment.strftime("%Y-%m-%dT%H:%M:%S")
        case "nano":
            return moment.strftime("%Y-%m-%dT%H:%M:%S.%f") + "000"
        case "day-z":
            return moment.strftime("%Y-%jT%H:%M:%SZ")
    return moment.strftime("%Y-%m-%dT%H:%M:%S.%f")


def state(lines, moment, frame):
    return teme(lines, moment) if frame.startswith("TEME") else earth_fixed(lines, moment)


def block(
    lines, first_s, last_s, step_s, *, frame="ITRF2020", form="plain", keys=None, columns=6, unit=1e-3,
    velocity_unit=None, digits=9, edit=None, separator=" ", drop=(), object_id="2013-008A", stated=None,
):  # fmt: skip
    """Lines of a segment: metadata and states."""
    times = np.arange(first_s, last_s + 0.5 * step_s, step_s)
    span = stated or (times[0], times[-1])
    moments = [START + timedelta(seconds=float(time)) for time in times]
    meta = {
        "OBJECT_NAME": "SATELLITE", "OBJECT_ID": object_id, "CENTER_NAME": "EARTH", "REF_FRAME": frame,
        "TIME_SYSTEM": "UTC", "START_TIME": stamp(START + timedelta(seconds=float(span[0])), form),
        "STOP_TIME": stamp(START + timedelta(seconds=float(span[1])), form),
    } | (keys or {})  # fmt: skip
    text = ["META_START", *(f"{key} = {value}" for key, value in meta.items() if key not in drop), "META_STOP"]
    for number, moment in enumerate(moments):
        position, velocity = state(lines, moment, frame)
        if edit is not None:
            position, velocity = edit(number, position, velocity)
        radius = np.linalg.norm(position)
        gravity = -3.986004418e14 * position / max(radius, 1.0) ** 3
        speed_unit = unit if velocity_unit is None else velocity_unit
        values = np.concatenate((position * unit, velocity * speed_unit, gravity * unit))[:columns]
        text.append(separator.join((stamp(moment, form), *(f"{value:.{digits}f}" for value in values))))
    return text


def message(*blocks, version="2.0", end="\n", start=b"", comment=True):
    text = [f"CCSDS_OEM_VERS = {version}", *(["COMMENT made for a test"] if comment else [])]
    text += ["CREATION_DATE = 2024-04-19T00:00:00", "ORIGINATOR = TEST", ""]
    for block in blocks:
        text += [*block, ""]
    return start + end.join(text).encode()


COVARIANCE = (
    "COVARIANCE_START", "EPOCH = 2024-04-20T02:30:00", "COV_REF_FRAME = ITRF2020", "1.0", "0.0 1.0", "0.0 0.0 1.0",
    "0.0 0.0 0.0 1.0", "0.0 0.0 0.0 0.0 1.0", "0.0 0.0 0.0 0.0 0.0 1.0", "COVARIANCE_STOP",
)  # fmt: skip


def good():
    """Return 100 inputs that must be read."""
    return [*_good_elements(), *_good_messages()]


def _elements_file(name, lines, content, **more):
    more = {"within_m": 20.0, "start": START} | more
    return OrbitInput(
        name,
        {"provider": "tle", "file": "elements.tle"},
        content,
        positions(lines, more["start"]),
        place=below(lines, more["start"]),
        **more,
    )


def _good_elements():
    result = []
    for number in range(50):
        orbit = list(ORBITS)[number % len(ORBITS)]
        age = [0.1, 1.0, 2.5, 4.0, 6.0, -0.5, -2.0][number % 7]
        start = START if number % 5 else datetime(2016, 8, 1 + number % 20, 7, 12, 13, tzinfo=UTC)
        catalogue = ["39084", "25544", "    5", "00005", "A0001", "Z9999", "39084"][number % 7].strip()
        changes = [{}, {"kind": "C"}, {"ndot": "-.00000500"}, {"drag": "-12000-4"}, {"set": "   1"}][number % 5]
        lines = elements(orbit, age, catalogue, number, start, **changes)
        first, second = lines
        text = [
            f"{first}\n{second}\n", f"{first}\r\n{second}\r\n", f"\ufeff{first}\n{second}",
            f"SATELLITE 1\n{first}\n{second}\n",
            f"0 SATELLITE 1\n{first}\n{second}\n", f"{first}   \n{second}\t\n", f"\n\n{first}\n\n{second}\n\n",
            f"\ufeffSATELLITE\r\n{first}\r\n{second}", f"SATELLITE (HIGH)   \n{first}\n{second}\n \n",
            f"{first}\r{second}\r",
        ][number % 10]  # fmt: skip
        name = f"elements {number}: {orbit}, {age:g} days, {catalogue}, {text[:3]!r}"
        if number % 11 == 10:
            result.append(
                OrbitInput(
                    f"{name} in the scenario",
                    {"provider": "tle", "lines": [f"{first}  ", f"{second}\n"] if number % 2 else [first, second]},
                    None,
                    positions(lines, start),
                    place=below(lines, start),
                    start=start,
                )
            )
        else:
            result.append(_elements_file(name, lines, text.encode(), start=start))
    return result


def _message_file(name, lines, content, **more):
    return OrbitInput(
        name, {"provider": "oem", "file": "orbit.oem"}, content, positions(lines), place=below(lines), **more
    )


def _good_messages():
    result = []
    forms = ("plain", "day", "z", "whole", "nano", "day-z")
    frames = ("ITRF2020", "ITRF2014", "ITRF-93", "TEME", "ITRF2000")
    for number in range(50):
        orbit = list(ORBITS)[number % len(ORBITS)]
        lines = elements(orbit, 1.0, seed=1000 + number)
        frame, form = frames[number % 5], forms[number % 6]
        slow = orbit in ("navigation", "geostationary")
        step = 600.0 if slow else [60.0, 120.0, 180.0, 30.0][number % 4]
        common = {"frame": frame, "form": form}
        before, after = 10.0 * step, 10.0 * step
        name = f"message {number}: {orbit}, {frame}, {form}, {step:g} s"
        within = 2.0
        match number % 10:
            case 0:
                content = message(block(lines, -before, after, step, **common), version="1.0")
                name += ", version 1"
            case 1:
                content = message(block(lines, -before, after, step, columns=9, **common), version="3.0")
                name += ", accelerations"
            case 2:
                keys = {"INTERPOLATION": "HERMITE", "INTERPOLATION_DEGREE": "7"}
                content = message(block(lines, -before, after, step, keys=keys, **common), end="\r\n")
                name += ", Hermite 7"
                within = 5.0  # the velocities of SGP4 are those of positions within 2 cm/s
            case 3:
                keys = {"INTERPOLATION": "LAGRANGE", "INTERPOLATION_DEGREE": "7"}
                spacing_s = min(step, 60.0) if not slow else step
                content = message(block(lines, -10 * spacing_s, 10 * spacing_s, spacing_s, keys=keys, **common))
                name += ", Lagrange 7"
            case 4:
                content = message([*block(lines, -before, after, step, **common), *COVARIANCE], start=b"\xef\xbb\xbf")
                name += ", covariance, byte-order mark"
            case 5:
                parts = [block(lines, -before, 0.0, step, **common), block(lines, 0.0, after, step, **common)]
                content = message(*parts)
                name += ", two segments"
            case 6:
                keys = {
                    "USEABLE_START_TIME": stamp(START - timedelta(seconds=step), form),
                    "USEABLE_STOP_TIME": stamp(START + timedelta(seconds=200.0 + step), form),
                }
                content = message(block(lines, -before, 200.0 + after, step, keys=keys, **common))
                name += ", usable span"
            case 7:
                made = block(lines, -before, after, step, separator="\t", digits=6, **common)
                content = message([f"{line}  " for line in made], version="2.0")
                name += ", tabs and trailing blanks, metres to 1 mm"
            case 8:
                keys = {"CENTER_NAME": "Earth", "OBJECT_NAME": "EAGLE_STOP"}
                spacing_s = step if slow else 300.0 if orbit != "eccentric" else 60.0
                made = block(lines, -10 * spacing_s, 10 * spacing_s, spacing_s, keys=keys, **common)
                made[1:1] = ["COMMENT a = b", "COMMENT"]
                content = message(made, comment=False)
                name += f", Earth in small letters, every {spacing_s:g} s"
                within = 20.0
            case _:
                made = block(lines, -before, after, step, digits=3, **common)
                content = message([*made[:-1], "COMMENT the last", made[-1]])
                name += ", positions to 1 m, comment between states"
                within = 10.0
        result.append(_message_file(name, lines, content, within_m=within))
    return result


def bad():
    """Return inputs (more than 100) that must be refused, or noted where they are doubtful."""
    return [*_bad_elements(), *_bad_messages()]


def _bad_tle(name, first, second, names, *, place=None, raw=None):
    content = f"{first}\n{second}\n".encode() if raw is None else raw
    return OrbitInput(
        f"elements: {name}", {"provider": "tle", "file": "elements.tle"}, content, names=names, place=place
    )


def _with(line, where, text):
    return with_checksum(line[:where] + text + line[where + len(text) :])


def _bad_elements():
    result = []
    for age in (30.0, 31.0, 45.0, 60.0, 90.0, 150.0, 200.0, 400.0, 1000.0, -30.0, -400.0):
        for orbit in ("polar",) if age % 2 else ("polar", "geostationary"):
            lines = elements(orbit, age, seed=2000)
            try:
                position_deg = below(lines)
            except AssertionError:
                position_deg = None
            result.append(_bad_tle(f"{orbit}, {age:g} days old", *lines, r"days|epoch", place=position_deg))
    for number, other in enumerate(("25544", "39085", "A0001", "    5", "00001", "93084")):
        first, _ = elements("polar", 1.0, "39084", 3000 + number)
        _, second = elements("station", 1.0, other.strip(), 3000 + number)
        result.append(_bad_tle(f"line 2 of {other}", first, second, r"catalogue number"))
    first, second = elements("polar", 1.0, seed=4000)
    for where in (20, 25, 40, 55, 63):
        digit = first[where]
        swapped = str((int(digit) + 1) % 10) if digit.isdigit() else "5"
        result.append(
            _bad_tle(f"digit {where} of line 1", first[:where] + swapped + first[where + 1 :], second, "line1")
        )
    for where in (10, 20, 30, 40, 55):
        digit = second[where]
        swapped = str((int(digit) + 1) % 10) if digit.isdigit() else "5"
        result.append(
            _bad_tle(f"digit {where} of line 2", first, second[:where] + swapped + second[where + 1 :], "line2")
        )
    two = elements("polar", number="1") + elements("station", number="2")
    three = [line for number in "123" for line in (f"SAT {number}", *elements("polar", number=number))]
    result += [
        _bad_tle("lines exchanged", second, first, "line1"),
        _bad_tle("line 1 twice", first, first, "line2"),
        _bad_tle("a character short", first[:-1], second, "line1"),
        _bad_tle("a character too many", first, second + "7", "line2"),
        _bad_tle("letter O for zero", _with(first, 21, "O"), second, "line1"),
        _bad_tle("inclination 98.2 as text", first, _with(second, 8, " abc.def"), "line2"),
        _bad_tle("columns shifted", with_checksum(first[:18] + first[19:68] + " "), second, "line1"),
        _bad_tle("columns shifted", first, with_checksum(second[:8] + second[9:60] + " " + second[60:68]), "line2"),
        _bad_tle("comma for point", _with(first, 23, ","), second, "line1"),
        _bad_tle("comma for point in line 2", first, _with(second, 11, ","), "line2"),
        _bad_tle("day 400", _with(first, 20, "400"), second, "line1"),
        _bad_tle("day 000", _with(first, 20, "000"), second, "line1"),
        _bad_tle("inclination 200", first, _with(second, 8, "200.0000"), "line2"),
        _bad_tle("no motion", first, _with(second, 52, " 0.00000000"), "line2"),
        _bad_tle("25 revolutions a day", first, _with(second, 52, "25.00000000"), "line2|SGP4|Earth"),
        _bad_tle("perigee in the Earth", first, _with(second, 26, "4000000"), "line2|perigee"),
        _bad_tle("two satellites", "", "", "orbit.file", raw="\n".join(two).encode()),
        _bad_tle("three satellites with names", "", "", "orbit.file", raw="\n".join(three).encode()),
        _bad_tle("empty", "", "", "orbit.file", raw=b""),
        _bad_tle("one line", "", "", "orbit.file", raw=first.encode()),
        _bad_tle("not text", "", "", "orbit.file", raw=bytes(range(128, 256))),
        _bad_tle("UTF-16", "", "", "orbit.file", raw=f"{first}\n{second}".encode("utf-16")),
        _bad_tle("a message of another kind", "", "", "orbit|line", raw=b'[{"NAME": "X",\n"MEAN_MOTION": 15.5}]'),
        _bad_tle("blanks became tabs", first.replace("  ", "\t"), second, "line1"),
    ]  # fmt: skip
    return result


def _bad_oem(name, content, names, place=None):
    return OrbitInput(f"message: {name}", {"provider": "oem", "file": "orbit.oem"}, content, names=names, place=place)


def _bad_messages():
    lines, other = elements("polar", 1.0, seed=5000), elements("station", 1.0, seed=5001)
    position_deg = below(lines)
    result = []

    def add(name, names, *blocks, **more):
        result.append(_bad_oem(name, message(*blocks, **more), names, position_deg))

    def one(step=60.0, points=10, **more):
        return block(lines, -points * step, points * step, step, **more)

    def renamed(old, new, made):
        return [line.replace(old, new) for line in made]

    for centre in ("MARS", "MOON", "SUN", "MARS BARYCENTER", "EARTH-MOON BARYCENTER"):
        add(f"centre {centre}", "CENTER_NAME", one(keys={"CENTER_NAME": centre}))
    add("no centre", "CENTER_NAME", one(drop=("CENTER_NAME",)))
    add("metres", "km|radius|altitude|speed", one(unit=1.0))
    add("metres, velocities in km/s", "km|radius|altitude", one(unit=1.0, velocity_unit=1e-3))
    add("velocities in m/s", "km|speed|velocit", one(velocity_unit=1.0))
    add("no velocities to speak of", "velocit", one(edit=lambda n, p, v: (p, 0.0 * v)))
    add("velocities backward", "velocit", one(edit=lambda n, p, v: (p, -v)))
    add("miles", "altitude|radius|Earth|gravity", one(unit=1e-3 / 1.609344))
    add("feet", "altitude|radius|Earth|gravity", one(unit=1e-3 / 0.3048))
    add("inside the Earth", "altitude|radius|Earth", one(edit=lambda n, p, v: (0.8 * p, v)))
    add("zeros", "altitude|radius|Earth", one(edit=lambda n, p, v: (0.0 * p, 0.0 * v)))
    add("orbit of Mars called Earth", "gravity|velocit|speed", one(edit=_around_mars))
    for step in (600.0, 900.0, 1200.0):
        add(f"every {step:g} s without velocities", "apart|spac|interpol", one(step, 2, columns=3))
        add(
            f"every {step:g} s, linear",
            "apart|spac|interpol|INTERPOLATION",
            one(step, 5, keys={"INTERPOLATION": "LINEAR", "INTERPOLATION_DEGREE": "1"}),
        )
    add(
        "every 300 s, Lagrange 3",
        "apart|spac|interpol",
        one(300.0, 4, keys={"INTERPOLATION": "LAGRANGE", "INTERPOLATION_DEGREE": "3"}),
    )
    add(
        "every 900 s, Lagrange 5",
        "apart|spac|interpol",
        one(900.0, 4, keys={"INTERPOLATION": "LAGRANGE", "INTERPOLATION_DEGREE": "5"}),
    )
    add("unknown interpolation", "INTERPOLATION", one(keys={"INTERPOLATION": "SPLINE", "INTERPOLATION_DEGREE": "3"}))
    add("degree 0", "INTERPOLATION_DEGREE", one(keys={"INTERPOLATION": "LAGRANGE", "INTERPOLATION_DEGREE": "0"}))
    add(
        "degree seven", "INTERPOLATION_DEGREE", one(keys={"INTERPOLATION": "LAGRANGE", "INTERPOLATION_DEGREE": "seven"})
    )
    add(
        "Hermite without velocities",
        "INTERPOLATION|velocit",
        one(columns=3, keys={"INTERPOLATION": "HERMITE", "INTERPOLATION_DEGREE": "7"}),
    )
    add(
        "usable span before the scenario",
        "USEABLE",
        one(
            keys={
                "USEABLE_START_TIME": stamp(START - timedelta(seconds=500)),
                "USEABLE_STOP_TIME": stamp(START - timedelta(seconds=100)),
            }
        ),
    )
    add(
        "usable span ends within the scenario",
        "USEABLE",
        one(
            keys={
                "USEABLE_START_TIME": stamp(START - timedelta(seconds=500)),
                "USEABLE_STOP_TIME": stamp(START + timedelta(seconds=40)),
            }
        ),
    )
    add(
        "usable span ends before it begins",
        "USEABLE",
        one(
            keys={
                "USEABLE_START_TIME": stamp(START + timedelta(seconds=100)),
                "USEABLE_STOP_TIME": stamp(START - timedelta(seconds=100)),
            }
        ),
    )
    add("gap between segments", "segment|span|time", block(lines, -600.0, 0.0, 60.0), block(lines, 120.0, 600.0, 60.0))
    add(
        "second satellite",
        "OBJECT_ID",
        block(lines, -600.0, 0.0, 60.0),
        block(other, 0.0, 600.0, 60.0, object_id="1998-067A"),
    )
    add("overlapping segments", "overlap", block(lines, -600.0, 120.0, 60.0), block(other, 0.0, 600.0, 60.0))
    add(
        "second segment in another frame",
        "REF_FRAME",
        block(lines, -600.0, 0.0, 60.0),
        renamed("TEME", "EME2000", block(lines, 0.0, 600.0, 60.0, frame="TEME")),
    )
    add(
        "second segment of the Moon",
        "CENTER_NAME",
        block(lines, -600.0, 0.0, 60.0),
        block(lines, 0.0, 600.0, 60.0, keys={"CENTER_NAME": "MOON"}),
    )
    for frame in ("EME2000", "ICRF", "GCRF", "J2000", "TOD"):
        add(f"frame {frame}", "REF_FRAME", renamed("= TEME", f"= {frame}", one(frame="TEME")))
    for system in ("TAI", "GPS", "TT", "TDB", "UT1"):
        add(f"times in {system}", "TIME_SYSTEM", one(keys={"TIME_SYSTEM": system}))
    add("inertial called Earth-fixed", "gravity|velocit|frame", renamed("= TEME", "= ITRF2020", one(frame="TEME")))
    add("TEME of an epoch", "REF_FRAME_EPOCH|REF_FRAME", one(frame="TEME", keys={"REF_FRAME_EPOCH": stamp(START)}))
    add("version 7", "CCSDS_OEM_VERS", one(), version="7.0")
    add("a digit wrong", "gravity|velocit", one(edit=lambda n, p, v: (p + (n == 10) * np.array([0.0, 1e5, 0.0]), v)))
    add("nan", "line|finite", renamed(one()[20].split()[1], "nan", one()))
    add("a time twice", "line|later|epoch", [*one()[:20], one()[19], *one()[20:]])
    add("times backward", "line|later|epoch", [*one()[:11], *reversed(one()[11:])])
    add("zone of Japan", "line|time", renamed(".000000 ", "+09:00 ", one()))
    add("four numbers", "line|numbers", one(columns=4))
    add(
        "no META_START for the second block",
        "META|line",
        block(lines, -600.0, 0.0, 60.0),
        block(lines, 0.0, 600.0, 60.0)[1:],
    )
    add("one state", "line|two|state", one()[:10])
    add("no states", "state|segment", [line for line in one() if not line.startswith("2024")])
    away = (position_deg[0] - 30.0 if position_deg[0] > 0 else position_deg[0] + 30.0, position_deg[1])
    result.append(_bad_oem("place 3300 km away", message(one()), "place", away))
    return result


def _around_mars(number, position, velocity):
    """The velocity of the same orbit around the mass of Mars."""
    return position, velocity * math.sqrt(4.282837e13 / 3.986004418e14)
