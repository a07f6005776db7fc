"""Run time against error as text for a terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from hcss_twin.benchmarking.bench import AccuracyResult, BenchResult
from hcss_twin.benchmarking.stages import CERTIFICATE, RAW, RUNS, STAGES

_WIDTH = 34
_CELL = 11
_OWN = "*"
_MISSED = "!"


def bench_text(found: BenchResult) -> str:
    """Return a table with a column for each accuracy, and one of brute force."""
    return "\n".join(_lines(found))


def _lines(found: BenchResult) -> Iterator[str]:
    results = found.accuracies
    yield found.scene
    yield (
        f"medians of {found.rounds} rounds that take turns (tables and certificates: once); "
        "trust ratios, seconds are this machine's of now"
    )
    yield ""
    yield _row("accuracy asked for", [_asked(each) for each in results])
    if any(_is_kelvin(each) for each in results):
        yield _row("as a share of the radiance", [f"{each.accuracy:.1e}" for each in results])
        yield _row("error found, K", [_found_K(each) for each in results])
    yield _row("error found, any band", [_found(each) for each in results])
    yield _row("error the tables estimate", [f"{each.estimated:.1e}" for each in results])
    yield "seconds"
    for stage in (*STAGES, CERTIFICATE, *RUNS, RAW):
        yield _row(f"  {stage}", [_short(each.seconds[stage]) for each in results])
    for title, ratio in _RATIOS:
        yield title
        for run in RUNS:
            yield _row(f"  {run}", [_short(ratio(each)[run]) for each in results])
    if any(each.own for each in results):
        yield f"{_OWN} the scenario's own accuracy"
    if any(each.exceeding for each in results):
        yield f"{_MISSED} pixels that exceed the accuracy asked for"
    checked = sorted({each.checked for each in results})
    yield (
        f"error found: of {' to '.join(map(str, checked))} random pixels against the reference path; whole runs are "
        "without the certificate"
    )
    yield ""
    yield (
        f"brute force, the spectrum of every point integrated: timed on {found.timed_points} points and scaled to "
        f"{found.points}; what the model computes once is left out"
    )
    yield _row("wavenumbers, points at once", ["ms a point", "hours", "over raw", "error"])
    for peer in found.brute_force:
        cells = [
            _short(1e3 * peer.seconds_per_point),
            _short(peer.seconds / 3600),
            _short(peer.over_raw),
            "reference" if peer.every == 1 else f"{peer.error:.1e}",
        ]
        yield _row(f"  {peer.wavenumbers}, {peer.together}", cells)


_RATIOS: tuple[tuple[str, Callable[[AccuracyResult], dict[str, float]]], ...] = (
    ("times as long as writing the same bytes raw", lambda each: each.over_raw),
    ("times faster than brute force", lambda each: each.over_brute_force),
)


def _row(name: str, cells: list[str]) -> str:
    return f"{name:<{_WIDTH}}" + "".join(f"{cell:>{_CELL}}" for cell in cells)


def _is_kelvin(result: AccuracyResult) -> bool:
    return result.asked.endswith("K")


def _asked(result: AccuracyResult) -> str:
    return (result.asked if _is_kelvin(result) else _power(result.accuracy)) + (_OWN if result.own else "")


def _power(value: float) -> str:
    """Write a power of ten as one, other numbers with the digits they have."""
    return f"{value:.0e}" if float(f"{value:.0e}") == value else f"{value:.3g}"


def _found_K(result: AccuracyResult) -> str:
    if not _is_kelvin(result):
        return "-"
    if result.achieved_K is None:
        return "unknown"
    return f"{result.achieved_K:.1e}" + (_MISSED if result.exceeding else "")


def _found(result: AccuracyResult) -> str:
    if result.achieved is None:
        return "unknown"
    return f"{result.achieved:.1e}" + (_MISSED if result.exceeding else "")


def _short(value: float) -> str:
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"
