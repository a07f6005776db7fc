"""At how many views the tables of wide fields lie, and what is left between them; no scene is computed.

python benchmarks/wide_field.py              # a few minutes
"""

from __future__ import annotations

from hcss_twin.core.errors import ScenarioError
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.scenario.scenario import Scenario

PIXELS = 50
NIGHT = {"time": "2024-04-20T00:30:00+10:00"}
FIELDS = (
    (1, "", {}),
    (16, "", {}),
    (50, "", {}),
    (50, "accuracy 1e-2", {"accuracy": 1e-2}),
    (200, "accuracy 1e-2", {"accuracy": 1e-2}),
    (200, "from 36 000 km", {"platform.altitude": "36000 km"}),
    (500, "band lwir alone", {"bands": ["lwir"]}),
    (500, "at night", NIGHT),
    (500, "as-printed", {"radiance.model": "as-printed", "sea.model": "cox-munk", "optics.provider": "mie"}),
)


def row(width_km: int, what: str, overrides: dict[str, object]) -> str:
    """One line of the table."""
    shape = {"image.rows": PIXELS, "image.columns": PIXELS, "image.pixel_size": 1e3 * width_km / PIXELS}
    fixed = {"frames.count": 1, "platform.altitude": "800 km", "output.variables": ["radiance"]}
    try:
        plan = make_plan(Scenario.load("stratus", {**shape, **fixed, **overrides}))
    except ScenarioError as error:
        return f"| {width_km} km | {what} | refused | {error.problems[0].message.partition(';')[0]} |"
    allowed = f"{plan.budget.views:.1e}"
    if plan.views is None:
        return f"| {width_km} km | {what} | 1 | of {allowed}: see the ledger |"
    views = f"{plan.views.order_x + 1} x {plan.views.order_y + 1}"
    return f"| {width_km} km | {what} | {views} | {plan.views.estimated_error:.1e} of {allowed} |"


def main() -> None:
    """Print the table of docs/how-to/viewing-geometry.md."""
    print("| width | | views | error found, of that allowed |\n|---|---|---|---|")
    for field in FIELDS:
        print(row(*field), flush=True)


if __name__ == "__main__":
    main()
