"""Two-line elements and orbit messages: 200 that must be read, with the positions they mean, and bad ones.

Positions come from SGP4 (package sgp4), sidereal time and the classical matrices of precession and nutation from ERFA,
and never from the readers that are judged. Every input is determined by its number.
"""

import json
import math
import re
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


LEAP_S = {"UTC": 0.0, "TAI": 37.0, "GPS": 18.0, "TT": 69.184}
"""Time in each scale less UTC, in 2024."""


@lru_cache(maxsize=10_000)
def celestial(moment, frame):
    """Matrix from a frame that does not turn to the Earth-fixed one, the classical way: equinox and sidereal time."""
    import erfa

    midnight = datetime(moment.year, moment.month, moment.day, tzinfo=UTC)
    days = float((midnight - datetime(2000, 1, 1, 12, tzinfo=UTC)).days) + 0.5
    part = (moment - midnight).total_seconds() / 86400.0
    first, terrestrial = 2451545.0 + days, part + LEAP_S["TT"] / 86400.0
    turn = erfa.rz(erfa.gst06a(first, part, first, terrestrial), erfa.pnm06a(first, terrestrial))
    return turn @ erfa.bp06(2451545.0, 0.0)[0].T if frame in ("EME2000", "J2000") else turn


def state(lines, moment, frame):
    if frame.startswith("TEME"):
        return teme(lines, moment)
    position, velocity = earth_fixed(lines, moment)
    if frame.startswith(("ITRF", "WGS")):
        return position, velocity
    turn = celestial(moment, frame)
    return turn.T @ position, turn.T @ (velocity + np.cross([0.0, 0.0, RATE], position))


def block(
    lines, first_s, last_s, step_s, *, frame="ITRF2020", form="plain", keys=None, columns=6, unit=1e-3,
    velocity_unit=None, digits=9, edit=None, separator=" ", drop=(), object_id="2013-008A", stated=None, scale="UTC",
):  # fmt: skip
    """Lines of a segment: metadata and states."""
    times = np.arange(first_s, last_s + 0.5 * step_s, step_s)
    span = stated or (times[0], times[-1])
    moments = [START + timedelta(seconds=float(time)) for time in times]
    later = timedelta(seconds=LEAP_S.get(scale, 0.0))
    zero = START + later
    meta = {
        "OBJECT_NAME": "SATELLITE", "OBJECT_ID": object_id, "CENTER_NAME": "EARTH", "REF_FRAME": frame,
        "TIME_SYSTEM": scale, "START_TIME": stamp(zero + timedelta(seconds=float(span[0])), form),
        "STOP_TIME": stamp(zero + timedelta(seconds=float(span[1])), form),
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
        text.append(separator.join((stamp(moment + later, form), *(f"{value:.{digits}f}" for value in values))))
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
    """Return 200 inputs that must be read."""
    return [*_good_elements(), *_good_messages(), *_everyday_messages(), *_mean_elements()]


def _everyday_messages():
    """60 ephemeris messages: five frames, four time scales, text, XML, and several segments of 21 states."""
    result = []
    frames = ("EME2000", "GCRF", "ICRF", "TEME", "ITRF2014")
    for number in range(60):
        orbit = LOW[number % 4]
        lines = elements(orbit, 1.0, seed=7000 + number)
        frame, scale, kind = (
            frames[number % 5],
            list(LEAP_S)[number // 5 % 4],
            ("text", "XML", "segments")[number // 20],
        )
        common = {"frame": frame, "scale": scale, "form": ("plain", "day", "z")[number % 3]}
        step = (60.0, 120.0, 240.0)[number % 3]
        if kind == "segments":
            blocks = [block(lines, -10.0 * step, 30.0, (10.0 * step + 30.0) / 20.0, **common),
                      block(lines, 30.0, 30.0 + 20.0 * step, step, **common)]  # fmt: skip
        else:
            blocks = [block(lines, -10.0 * step, 10.0 * step, step, **common)]
        mark = b"\xef\xbb\xbf" if number % 4 == 1 else b""
        content = xml(*blocks, start=mark, combined=number % 2 == 0) if kind == "XML" else message(*blocks, start=mark)
        if number % 7 == 3 and kind != "XML":
            content = content.decode().encode("utf-16")
        name = f"everyday {number}: {orbit}, {frame}, {scale}, {kind}, every {step:g} s"
        result.append(_message_file(name, lines, content, within_m=20.0 if step > 200.0 else 5.0))
    return result


def xml(*blocks, start=b"", combined=False):
    """A message in XML from the lines of segments."""
    text = ['<?xml version="1.0" encoding="UTF-8"?>', *(["<ndm>"] if combined else [])]
    text += ['<oem id="CCSDS_OEM_VERS" version="2.0">', "<header><COMMENT>a = b</COMMENT>"]
    text += ["<CREATION_DATE>2024-04-19T00:00:00</CREATION_DATE><ORIGINATOR>TEST</ORIGINATOR></header><body>"]
    names = ("EPOCH", "X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT")
    for lines in blocks:
        stop = lines.index("META_STOP")
        meta = [re.sub(r"(\S+) = (.*)", r"<\1>\2</\1>", line) for line in lines[1:stop]]
        text += ["<segment><metadata>", *meta, "</metadata><data>", "<COMMENT>made for a test</COMMENT>"]
        for line in lines[stop + 1 :]:
            unit = dict(zip(names, ["", *3 * [' units="km"'], *3 * [' units="km/s"']], strict=True))
            values = zip(names, line.split(), strict=False)
            text.append(f"<stateVector>{''.join(f'<{n}{unit[n]}>{v}</{n}>' for n, v in values)}</stateVector>")
        text += ["<covarianceMatrix><EPOCH/><CX_X>1.0</CX_X></covarianceMatrix>", "</data></segment>"]
    text += ["</body></oem>", *(["</ndm>"] if combined else [])]
    return start + "\n".join(text).encode()


def omm_keys(lines, number="39084", **changes):
    """Keys of a mean-elements message with the numbers of two lines."""
    from sgp4.api import Satrec

    satellite = Satrec.twoline2rv(*lines)
    epoch = datetime(2000, 1, 1, 12, tzinfo=UTC) + timedelta(
        days=satellite.jdsatepoch - 2451545.0
    ) + timedelta(days=satellite.jdsatepochF)  # fmt: skip
    degrees = {
        "INCLINATION": satellite.inclo, "RA_OF_ASC_NODE": satellite.nodeo, "ARG_OF_PERICENTER": satellite.argpo,
        "MEAN_ANOMALY": satellite.mo,
    }  # fmt: skip
    return {
        "OBJECT_NAME": "SATELLITE 1", "OBJECT_ID": "2013-008A", "CENTER_NAME": "EARTH", "REF_FRAME": "TEME",
        "TIME_SYSTEM": "UTC", "MEAN_ELEMENT_THEORY": "SGP4", "EPOCH": stamp(epoch),
        "MEAN_MOTION": f"{satellite.no_kozai * 720.0 / math.pi:.8f}", "ECCENTRICITY": f"{satellite.ecco:.7f}",
        **{key: f"{math.degrees(value):.4f}" for key, value in degrees.items()},
        "EPHEMERIS_TYPE": "0", "CLASSIFICATION_TYPE": "U", "NORAD_CAT_ID": number, "ELEMENT_SET_NO": "999",
        "REV_AT_EPOCH": "1", "BSTAR": f"{satellite.bstar:.8f}", "MEAN_MOTION_DOT": "0", "MEAN_MOTION_DDOT": "0",
    } | changes  # fmt: skip


def omm(keys, kind, start=b""):
    """A mean-elements message as text, XML, JSON or CSV."""
    if kind == "CSV":
        return start + f"{','.join(keys)}\r\n{','.join(keys.values())}\r\n".encode()
    if kind == "JSON":
        number = re.compile(r"-?(0|[1-9]\d*)(\.\d+)?")
        values = {key: json.loads(value) if number.fullmatch(value) else value for key, value in keys.items()}
        return start + json.dumps([values]).encode()
    if kind == "text":
        return start + "\n".join(
            ["CCSDS_OMM_VERS = 2.0", "CREATION_DATE =", "COMMENT made for a test", "", *(
                f"{key:14} = {value}" for key, value in keys.items())]
        ).encode()  # fmt: skip
    names = list(keys)
    parts = (names[:6], names[6:13], names[13:])
    inside = ["".join(f"<{key}>{keys[key]}</{key}>" for key in part) for part in parts]
    return (
        start
        + (
            '<ndm><omm id="CCSDS_OMM_VERS" version="2.0"><header><CREATION_DATE/></header><body><segment>'
            f"<metadata>{inside[0]}</metadata><data><meanElements>{inside[1]}</meanElements>"
            f"<tleParameters>{inside[2]}</tleParameters></data></segment></body></omm></ndm>"
        ).encode()
    )


def _mean_elements():
    """40 mean-elements messages, with catalogue numbers beyond those of two lines."""
    result = []
    for number in range(40):
        orbit = list(ORBITS)[number % 7]
        lines = elements(orbit, 1.0, seed=8000 + number)
        kind, catalogue = ("text", "XML", "JSON", "CSV")[number % 4], ("39084", "100001", "799999999")[number // 3 % 3]
        units = {"INCLINATION": omm_keys(lines)["INCLINATION"] + " [deg]"} if number % 8 == 4 and kind == "text" else {}
        mark = b"\xef\xbb\xbf" if number % 5 == 0 else b""
        content = omm(omm_keys(lines, catalogue, **units), kind, mark)
        result.append(
            OrbitInput(
                f"elements message {number}: {orbit}, {kind}, {catalogue}",
                {"provider": "omm", "file": "orbit.omm"},
                content,
                positions(lines),
                place=below(lines),
                within_m=30.0,
            )
        )
    return result


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
    return [*_bad_elements(), *_bad_messages(), *_bad_xml(), *_bad_mean_elements()]


def _bad_xml():
    lines = elements("polar", 1.0, seed=5000)
    content = xml(block(lines, -600.0, 600.0, 60.0))
    metres = content.replace(b'<X units="km">', b'<X units="m">')
    return [
        _bad_oem("XML that ends early", content[: len(content) // 2], "line .*not XML"),
        _bad_oem("XML in metres", metres, "line .*X in m; allowed: km"),
        _bad_oem(
            "XML with a word", re.sub(rb"<Y units=.km.>[^<]*", b"<Y>east", content, count=1), "no time with numbers"
        ),
        _bad_oem("XML in another frame", content.replace(b"ITRF2020", b"TOD"), "REF_FRAME TOD; allowed"),
        _bad_oem("a page of a server", b"<html><body>not found</body></html>", "no CCSDS_OEM_VERS"),
    ]


def _bad_mean_elements():
    keys = omm_keys(elements("polar", 1.0, seed=9000))
    faults = {
        "inclination 200": ({"INCLINATION": "200.0"}, "inclination 200 deg; allowed"),
        "no motion": ({"MEAN_MOTION": "0"}, "0 revolutions a day; allowed"),
        "eccentricity 1.5": ({"ECCENTRICITY": "1.5"}, "ECCENTRICITY 1.5; allowed"),
        "eccentricity as in two lines": ({"ECCENTRICITY": "0001000"}, "ECCENTRICITY 0001000; allowed"),
        "radians": ({"INCLINATION": "1.71 [rad]"}, "INCLINATION .*allowed: a number, in deg"),
        "a word": ({"MEAN_ANOMALY": "north"}, "MEAN_ANOMALY 'north'; allowed: a number"),
        "another theory": ({"MEAN_ELEMENT_THEORY": "SGP4-XP"}, "MEAN_ELEMENT_THEORY SGP4-XP; allowed: SGP4"),
        "elements of SGP4-XP": ({"EPHEMERIS_TYPE": "4"}, "EPHEMERIS_TYPE 4; allowed"),
        "another frame": ({"REF_FRAME": "EME2000"}, "REF_FRAME EME2000; allowed: TEME"),
        "Mars": ({"CENTER_NAME": "MARS"}, "CENTER_NAME MARS; allowed: EARTH"),
        "a date alone": ({"EPOCH": "2024-04-20"}, "EPOCH: '2024-04-20' is no time"),
        "too old": ({"EPOCH": "2021-04-20T00:00:00"}, "days older"),
        "zone": ({"EPOCH": "2024-04-20T00:00:00+09:00"}, "EPOCH.*no time"),
    }
    result = [
        OrbitInput(
            f"elements message: {name}, {kind}",
            {"provider": "omm", "file": "orbit.omm"},
            omm(keys | change, kind),
            names=names,
        )
        for name, (change, names) in faults.items()
        for kind in ("text", "XML", "JSON", "CSV")
    ]
    without = {key: value for key, value in keys.items() if key != "BSTAR"}
    two = omm(keys, "JSON")[:-1] + b"," + omm(keys, "JSON")[1:]
    rows = omm(keys, "CSV") + omm(keys, "CSV").partition(b"\n")[2]
    raw = {
        "no drag": (omm(without, "JSON"), "BSTAR is missing"), "two satellites": (two, "2 satellites; allowed"),
        "two rows": (rows, "2 rows below the labels; allowed: one"), "no row": (rows.partition(b"\n")[0], "0 rows"),
        "JSON that ends early": (omm(keys, "JSON")[:-9], "not JSON"), "no keys": (b"{}", "is missing"),
    }  # fmt: skip
    for name, (content, names) in raw.items():
        result.append(
            OrbitInput(f"elements message: {name}", {"provider": "omm", "file": "orbit.omm"}, content, names=names)
        )
    return result


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
        _bad_tle("UTF-16 without mark", "", "", "orbit.file", raw=f"{first}\n{second}".encode("utf-16-be")),
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
        renamed("TEME", "TOD", block(lines, 0.0, 600.0, 60.0, frame="TEME")),
    )
    add(
        "second segment of the Moon",
        "CENTER_NAME",
        block(lines, -600.0, 0.0, 60.0),
        block(lines, 0.0, 600.0, 60.0, keys={"CENTER_NAME": "MOON"}),
    )
    for frame in ("EME1950", "MOD", "RTN", "TOD", "ICRF BARYCENTRIC"):
        add(f"frame {frame}", "REF_FRAME", renamed("= TEME", f"= {frame}", one(frame="TEME")))
    for system in ("GLONASS", "MET", "TCG", "TDB", "UT1"):
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
