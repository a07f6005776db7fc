"""A hundred good and a hundred bad files of one ascent: CSV of the University of Wyoming, IGRA 2, and ERA5.

The ascent is a standard atmosphere whose humidity falls with height; a good file gives it back within its rounding. A
bad file has one fault, with a pattern of its message.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import netCDF4
import numpy as np

TIME = datetime(2024, 4, 20, 2, 30, tzinfo=UTC)
PLACE = 35.0, 150.0
HEIGHTS = np.array([0, 110, 320, 540, 760, 990, 1450, 1950, 3010, 4200, 5570, 7180, 9160, 10360, 11780, 13600, 16180.0])


def temperature_K(height):
    return np.maximum(288.15 - 6.5e-3 * height, 216.65)


def pressure_Pa(height):
    low = 101325.0 * np.maximum(1.0 - 6.5e-3 * np.minimum(height, 11e3) / 288.15, 0.1) ** 5.25588
    return low * np.exp(-np.maximum(height - 11e3, 0.0) / 6341.6)


def vapour_Pa(height):
    """Partial pressure by Bolton's formula (1980), of a relative humidity that falls with height."""
    celsius = temperature_K(height) - 273.15
    return 0.7 * np.exp(-height / 4000.0) * 611.2 * np.exp(17.67 * celsius / (celsius + 243.5))


def dewpoint_C(height):
    logarithm = np.log(vapour_Pa(height) / 611.2)
    return 243.5 * logarithm / (17.67 - logarithm)


def humidity(height):
    """Specific humidity, kg/kg."""
    vapour = vapour_Pa(height)
    return 0.622 * vapour / (pressure_Pa(height) - 0.378 * vapour)


@dataclass(frozen=True)
class Case:
    """A file, and a pattern: of what is told of a good one, of the message about a bad one."""

    name: str
    file: str
    content: bytes
    words: str = ""


def good() -> list[Case]:
    """Return the hundred good files."""
    files = [*_wyoming(), *_igra(), *_era5()]
    assert len({each.name for each in files}) == len(files) == 100
    return files


def bad() -> list[Case]:
    """Return the hundred bad files."""
    files = [*_bad_wyoming(), *_bad_igra(), *_bad_era5()]
    assert len({each.name for each in files}) == len(files) == 100
    return files


WYOMING = (
    "time", "longitude", "latitude", "pressure_hPa", "geopotential height_m", "temperature_C",
    "dew point temperature_C", "ice point temperature_C", "relative humidity_%", "humidity wrt ice_%",
    "mixing ratio_g/kg", "wind direction_degree", "wind speed_m/s",
)  # fmt: skip


def wyoming(heights=HEIGHTS, columns=WYOMING, pad="", edit=None, digits=1) -> list[str]:
    """Lines of a CSV of the present site."""
    lines = [",".join(columns)]
    for number, height in enumerate(heights):
        mixing = 622.0 * vapour_Pa(height) / (pressure_Pa(height) - vapour_Pa(height))
        values = {
            "time": f"{TIME + timedelta(seconds=float(height) / 5.0):%Y-%m-%d %H:%M:%S}",
            "longitude": "150.0000", "latitude": "35.0000", "pressure_hPa": f"{pressure_Pa(height) / 100:.{digits}f}",
            "geopotential height_m": f"{height:.0f}", "temperature_C": f"{temperature_K(height) - 273.15:.1f}",
            "dew point temperature_C": f"{dewpoint_C(height):.1f}", "ice point temperature_C": "-1.0",
            "relative humidity_%": f"{70.0 * np.exp(-height / 4000.0):.0f}", "humidity wrt ice_%": "50",
            "mixing ratio_g/kg": f"{mixing:.2f}", "wind direction_degree": "270", "wind speed_m/s": "5.0",
        }  # fmt: skip
        if edit is not None:
            edit(number, values)
        lines.append(",".join(f"{pad}{values[name]}" for name in columns))
    return lines


def _blank(*names: str, every: int = 3, text: str = "") -> Callable[[int, dict[str, str]], None]:
    def edit(number: int, values: dict[str, str]) -> None:
        if number % every == 1:
            values.update(dict.fromkeys(names, text))

    return edit


def _dense(step_m: float, top_m: float = 16180.0) -> np.ndarray:
    return np.arange(0.0, top_m, step_m)


def _wyoming() -> Iterator[Case]:
    """Files of the University of Wyoming: 34."""

    def case(name: str, lines: list[str], words: str = "", end: str = "\n", mark: str = "") -> Case:
        return Case(f"Wyoming: {name}", "ascent.csv", (mark + end.join(lines) + end).encode(), words)

    dense = np.sort(np.concatenate((HEIGHTS, _dense(100.0))))
    yield case("as it comes", wyoming())
    yield case("padded", wyoming(pad=" "))
    yield case("Windows", wyoming(), end="\r\n", mark="\ufeff")
    yield case("upper case", [wyoming()[0].upper().replace("_HPA", "_hPa"), *wyoming()[1:]])
    yield case("times alone left out", wyoming(columns=WYOMING[1:]))
    yield case("blank line at the end", [*wyoming(), "", ""])
    yield case("without positions", wyoming(columns=WYOMING[3:]))
    yield case("comment before", ["# station 47000", *wyoming()])
    for step in (5.0, 10.0, 20.0, 50.0, 100.0):
        words = "repeat" if step < 10.0 else ""
        yield case(f"every {step:g} m", wyoming(_dense(step)), words)
    for number in range(4):  # repeated levels at several places
        heights = np.sort(np.concatenate((HEIGHTS, HEIGHTS[number::4])))
        yield case(f"several rows of one pressure {number}", wyoming(heights), "repeat a pressure")
    for index, name in enumerate(("mixing ratio_g/kg", "dew point temperature_C", "relative humidity_%")):
        kept = [
            each
            for each in WYOMING
            if each == name or ("ratio" not in each and "point" not in each and "humid" not in each)
        ]
        yield case(f"only {name}", wyoming(columns=tuple(kept)))
        yield case(f"blanks in {name}", wyoming(dense, columns=tuple(kept), edit=_blank(name)), "without a value")
        yield case(
            f"all but {name} empty",
            wyoming(
                dense,
                edit=_blank(
                    *{"mixing ratio_g/kg", "dew point temperature_C", "relative humidity_%"} - {name}, every=1 + index
                ),
            ),
        )
    for text in ("", "nan", "NaN", " "):
        yield case(f"temperature {text!r}", wyoming(dense, edit=_blank("temperature_C", text=text)), "without a value")
    yield case("rows of wind alone", wyoming(dense, edit=_blank("temperature_C", "mixing ratio_g/kg",
        "dew point temperature_C", "relative humidity_%")), "without a value")  # fmt: skip
    yield case("ground wind blank", wyoming(edit=_blank("wind speed_m/s", "wind direction_degree")))

    def swing(number: int, values: dict[str, str]) -> None:
        if number in (1, 2):
            values["pressure_hPa"] = f"{float(values['pressure_hPa']) + 0.3 * (-1) ** number:.1f}"

    yield case("pressures that swing", wyoming(_dense(4.0), edit=swing), "repeat a pressure")
    yield case("heights that repeat", wyoming(_dense(0.4, 3000.0), digits=2), "repeat a pressure")


IGRA_HEAD = "#JAM00047000 {0.year:4d} {0.month:2d} {0.day:2d} {0.hour:02d} {1} {2:4d} ncdc-nws          350000  1500000"


def igra(heights=HEIGHTS, time=TIME, rh=True, dpdp=True, edit=None, released="0230") -> list[str]:
    """Lines of one sounding of IGRA 2."""
    lines = [IGRA_HEAD.format(time, released, len(heights))]
    for number, height in enumerate(heights):
        depression = (temperature_K(height) - 273.15 - dewpoint_C(height)) * 10.0
        values = {
            "type": "21" if number == 0 else "10", "press": pressure_Pa(height), "gph": height,
            "temp": (temperature_K(height) - 273.15) * 10.0,
            "rh": 700.0 * np.exp(-height / 4000.0) if rh else -9999, "dpdp": depression if dpdp else -9999,
        }  # fmt: skip
        if edit is not None:
            edit(number, values)
        lines.append(
            f"{values['type']} {-9999:5d} {values['press']:6.0f} {values['gph']:5.0f}B{values['temp']:5.0f}B"
            f"{values['rh']:5.0f} {values['dpdp']:5.0f} {270:5d} {50:5d} "
        )
    return lines


def _set(every: int = 3, **changes: float) -> Callable[[int, dict[str, float]], None]:
    def edit(number: int, values: dict[str, float]) -> None:
        if number % every == 1:
            values.update(changes)

    return edit


def _igra() -> Iterator[Case]:
    """Soundings of IGRA 2: 33."""
    dense = np.sort(np.concatenate((HEIGHTS, _dense(200.0))))

    def case(name: str, *soundings: list[str], words: str = "", end: str = "\n", mark: str = "") -> Case:
        text = mark + end.join(line for lines in soundings for line in lines) + end
        return Case(f"IGRA: {name}", "JAM00047000-data.txt", text.encode(), words)

    yield case("as it comes", igra())
    yield case("Windows", igra(), end="\r\n", mark="\ufeff")
    yield case("humidity alone", igra(dpdp=False))
    yield case("depression alone", igra(rh=False))
    yield case("no time of release", igra(released="9999"))
    yield case("blank line at the end", [*igra(), ""])
    for number, step in enumerate((50.0, 100.0, 200.0, 400.0, 700.0)):
        yield case(f"every {step:g} m {number}", igra(_dense(step)))
    for missing in (-9999.0, -8888.0):
        for key in ("temp", "rh", "gph", "press"):
            other = {"dpdp": missing} if key == "rh" else {}
            yield case(f"{key} {missing:g}", igra(dense, edit=_set(**{key: missing}, **other)), words="without a value")
    for hours in (6, 12, 24, 240):
        other = igra(HEIGHTS + 0.0, TIME - timedelta(hours=hours), edit=_set(1, temp=-300.0))
        yield case(f"an earlier sounding, {hours} h", other, igra(), words="sounding of 2024-04-20 02 UTC")
        yield case(
            f"a later sounding, {hours} h",
            igra(),
            igra(HEIGHTS, TIME + timedelta(hours=hours), edit=_set(1, temp=-300.0)),
            words="sounding of 2024-04-20 02 UTC",
        )
    for number in range(4):
        heights = np.sort(np.concatenate((HEIGHTS, HEIGHTS[number::4])))
        yield case(f"levels twice {number}", igra(heights), words="repeat a pressure")
    yield case("hour missing", [igra()[0].replace(" 02 0230", " 99 0230"), *igra()[1:]])
    wind = _set(2, temp=-9999.0, rh=-9999.0, dpdp=-9999.0, press=-9999.0, type=30)
    yield case("wind levels", igra(dense, edit=wind), words="without a value")


LEVELS_hPa = np.array([1000, 975, 950, 925, 900, 850, 800, 700, 600, 500, 400, 300, 250, 200, 150, 100.0])


def _height_of(pressure: np.ndarray) -> np.ndarray:
    heights = np.arange(-500.0, 40e3, 1.0)
    return np.interp(-pressure, -pressure_Pa(heights), heights)


def era5(
    style="new", *, times=(0.0,), ascending=False, packed=True, longitudes=(149.0, 150.0, 151.0), humid="q",
    geopotential=True, latitudes=(36.0, 35.0, 34.0), levels=LEVELS_hPa, edit=None,
) -> bytes:  # fmt: skip
    """A file of ERA5 on pressure levels, as downloaded: ``new`` since 2024, ``old`` before, ``grib`` by cfgrib."""
    level_name, time_name, unit = {
        "new": ("pressure_level", "valid_time", "hPa"), "old": ("level", "time", "millibars"),
        "grib": ("isobaricInhPa", "time", "hPa"),
    }[style]  # fmt: skip
    data = netCDF4.Dataset("era5.nc", "w", memory=1)
    pressures = np.sort(levels)[:: 1 if ascending else -1]
    for name, values in (
        (time_name, times), (level_name, pressures), ("latitude", latitudes), ("longitude", longitudes)
    ):  # fmt: skip
        data.createDimension(name, len(values))
    coordinates = {
        level_name: (pressures, {"units": unit}), "latitude": (latitudes, {"units": "degrees_north"}),
        "longitude": (longitudes, {"units": "degrees_east"}),
        time_name: (
            [(TIME - datetime(1900, 1, 1, tzinfo=UTC)).total_seconds() / 3600.0 - 0.5 + hour for hour in times],
            {"units": "hours since 1900-01-01 00:00:00.0", "calendar": "gregorian", "standard_name": "time"},
        ),
    }  # fmt: skip
    for name, (values, attributes) in coordinates.items():
        made = data.createVariable(name, "f8", (name,))
        made[:] = values
        made.setncatts(attributes)
    height = _height_of(100.0 * pressures)
    warmer = np.array([0.0 if hour == times[np.argmin(np.abs(times))] else 20.0 for hour in times])
    variables = {
        "t": (temperature_K(height), "K", "air_temperature"), "q": (humidity(height), "kg kg**-1", "specific_humidity"),
        "r": (70.0 * np.exp(-height / 4000.0), "%", "relative_humidity"),
        "z": (9.80665 * height, "m**2 s**-2", "geopotential"),
    }  # fmt: skip
    for name in ("t", humid, *(["z"] if geopotential else [])):
        values, units, standard = variables[name]
        shape = (len(times), len(pressures), len(latitudes), len(longitudes))
        field = np.broadcast_to(values[None, :, None, None], shape).copy()
        if name == "t":
            field += warmer[:, None, None, None]
        keys = {"fill_value": -32767} if packed else {}
        made = data.createVariable(
            name, "i2" if packed else "f4", (time_name, level_name, "latitude", "longitude"), **keys
        )
        if packed:
            low, high = field.min(), field.max()
            made.scale_factor, made.add_offset = (high - low) / 65000.0 or 1.0, 0.5 * (low + high)
        made.units, made.standard_name, made.long_name = units, standard, name
        made[:] = field
    if edit is not None:
        edit(data)
    return bytes(data.close())


def _era5() -> Iterator[Case]:
    """Files of the reanalysis: 33."""

    def case(name: str, content: bytes, words: str = "") -> Case:
        return Case(f"ERA5: {name}", "era5.nc", content, words)

    for style in ("new", "old", "grib"):
        for ascending in (False, True):
            for packed in (False, True):
                name = f"{style}, {'up' if ascending else 'down'} from {'packed' if packed else 'floats'}"
                yield case(name, era5(style, ascending=ascending, packed=packed))
        yield case(f"{style}, one place", era5(style, longitudes=(150.0,), latitudes=(35.0,)))
        yield case(f"{style}, relative humidity", era5(style, humid="r"))
        yield case(f"{style}, no geopotential", era5(style, geopotential=False), "altitudes computed")
        yield case(f"{style}, several times", era5(style, times=(-6.0, 0.0, 6.0)), "time 2024-04-20 02:00 UTC")
        yield case(
            f"{style}, times of one place",
            era5(style, times=(-3.0, 0.0, 3.0), longitudes=(150.0,), latitudes=(35.0,)),
            "time 2024-04-20 02:00 UTC",
        )
    yield case("-180 to 180 across", era5(longitudes=(-180.0, -90.0, 0.0, 90.0, 180.0)))
    yield case("a globe from -180", era5(longitudes=tuple(np.arange(-180.0, 180.0, 60.0))))
    yield case("a globe from 0", era5(longitudes=tuple(np.arange(0.0, 360.0, 60.0))))
    yield case("-210", era5(longitudes=(-211.0, -210.0, -209.0)))
    yield case("south to north", era5(latitudes=(34.0, 35.0, 36.0)))
    yield case("below the sea", era5(levels=np.append(LEVELS_hPa, 1013.25 * 1.01)), "below the sea")


def _bad_wyoming() -> Iterator[Case]:
    def case(name: str, lines: list[str], words: str) -> Case:
        return Case(f"Wyoming: {name}", "ascent.csv", ("\n".join(lines) + "\n").encode(), words)

    def one(key: str, text: str, number: int = 4) -> list[str]:
        return wyoming(edit=lambda row, values: values.update({key: text}) if row == number else None)

    for number in (2, 11):
        line = f"line {number + 2}"
        for key, name in (
            ("pressure_hPa", "pressure"),
            ("temperature_C", "temperature"),
            ("mixing ratio_g/kg", "mixing"),
        ):
            yield case(f"a word as {name} in {number}", one(key, "low", number), f"{line}: {key} 'low' is not a number")
            yield case(f"infinite {name} in {number}", one(key, "inf", number), f"{line}: {key} is inf")
        yield case(f"heat in {number}", one("temperature_C", "1700", number), f"{line}: temperature_C is 1700; allowed")
        yield case(f"kelvin in {number}", one("temperature_C", "-273.16", number), f"{line}: temperature_C .*allowed")
        yield case(f"water in {number}", one("mixing ratio_g/kg", "300", number), f"{line}: .* is 300; allowed")
        yield case(f"pressure up in {number}", one("pressure_hPa", "1050", number), f"{line}: pressure 1050 hPa")
        yield case(f"a field too few in {number}", [*wyoming()[: number + 1], "1,2,3"], f"line {number + 2}: 3 fields")
    yield case("Fahrenheit", [line.replace("temperature_C", "temperature_F") for line in wyoming()], "unknown unit")
    yield case("no unit", [line.replace("pressure_hPa", "pressure") for line in wyoming()], "'pressure' has no unit")
    yield case("no temperature", wyoming(columns=tuple(
        c for c in WYOMING if not c.startswith("temp"))), "temperature is missing")  # fmt: skip
    yield case("the answer of a server", ["Unable to retrieve the data for 47000"], "not known|no row|levels|unit")


def _bad_igra() -> Iterator[Case]:
    def case(name: str, lines: list[str], words: str) -> Case:
        return Case(f"IGRA: {name}", "JAM00047000-data.txt", ("\n".join(lines) + "\n").encode(), words)

    def one(number: int = 4, **changes: float) -> list[str]:
        return igra(edit=lambda row, values: values.update(changes) if row == number else None)

    for number in (2, 5, 8, 12):
        line = f"line {number + 2}"
        yield case(f"heat in {number}", one(number, temp=17000.0), f"{line}: temperature is 1700; allowed")
        yield case(f"pressure up in {number}", one(number, press=109000.0), f"{line}: pressure 1090 hPa")
        yield case(f"humid in {number}", one(number, rh=3000.0), f"{line}: relative_humidity is 300; allowed")
        yield case(f"height down in {number}", one(number, gph=20.0 - number), f"{line}.*geopotential_height")
        words = igra()
        words[number + 1] = words[number + 1].replace("B", "x", 1)[:17] + "high " + words[number + 1][22:]
        yield case(f"a word in {number}", words, f"{line}: .*'high' is not a number")
        yield case(
            f"line too short in {number}",
            [*igra()[: number + 1], "10 -9999 1013", *igra()[number + 2 :]],
            f"line {number + 2}: 13 char",
        )
        yield case(f"ends at {number}", igra()[:number], f"header .*17 levels, {number - 1} follow")
    yield case("no levels", igra()[:1], "header .*17 levels, 0 follow")
    yield case("no humidity", igra(rh=False, dpdp=False), "humidity is missing")
    yield case("one level", igra(HEIGHTS[:1]), "1 levels; at least 2")
    yield case("mountain", igra(HEIGHTS[6:]), "the lowest level is at")
    yield case("a gap", igra(np.array([0.0, 110.0, 7000.0, 9000.0])), "7.* km above")
    yield case("month 13", [igra()[0].replace("2024  4", "2024 13"), *igra()[1:]], "line 1: .*date")


def _bad_era5() -> Iterator[Case]:
    def case(name: str, content: bytes, words: str) -> Case:
        return Case(f"ERA5: {name}", "era5.nc", content, words)

    def renamed(name: str, key: str, value: str) -> Callable[[netCDF4.Dataset], None]:
        return lambda data: data[name].setncattr(key, value)

    def put(name: str, index: int, value: float) -> Callable[[netCDF4.Dataset], None]:
        def edit(data: netCDF4.Dataset) -> None:
            data[name][:, index] = value

        return edit

    for style in ("new", "old", "grib"):
        level = {"new": "pressure_level", "old": "level", "grib": "isobaricInhPa"}[style]
        for index in (1, 5) if style != "grib" else (1,):
            place = f"level {index + 1}"
            yield case(
                f"{style}, heat in {index}",
                era5(style, packed=False, edit=put("t", index, 1700.0)),
                f"{place}: t is 1700",
            )
            yield case(
                f"{style}, cold in {index}", era5(style, packed=False, edit=put("t", index, 0.0)), f"{place}: t is 0; "
            )
            yield case(
                f"{style}, water in {index}", era5(style, packed=False, edit=put("q", index, 0.9)), f"{place}: q is 0.9"
            )
            yield case(
                f"{style}, drought in {index}",
                era5(style, packed=False, edit=put("q", index, -0.9)),
                f"{place}: q is -0.9",
            )
            yield case(
                f"{style}, hole in {index}",
                era5(style, packed=False, edit=put("t", index, np.nan)),
                f"{place}: t is missing",
            )
        yield case(f"{style}, furlongs", era5(style, edit=renamed("z", "units", "furlong")), "unknown unit 'furlong'")
        if style != "grib":
            yield case(
                f"{style}, feet of pressure",
                era5(style, edit=renamed(level, "units", "ft")),
                "unknown unit 'ft'|pressure is missing",
            )
        yield case(f"{style}, no units", era5(style, edit=renamed("t", "units", "")), "'t' has no unit")
        yield case(f"{style}, elsewhere", era5(style, longitudes=(10.0, 11.0, 12.0)), "longitude .* lies outside")
        yield case(
            f"{style}, another hemisphere", era5(style, latitudes=(-36.0, -35.0, -34.0)), "latitude .* lies outside"
        )
    yield case("heights in m called geopotential", era5(packed=False, edit=lambda data: data["z"].__setitem__(
        slice(None), data["z"][:] / 9.80665)), "check the units")  # fmt: skip
