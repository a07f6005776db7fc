"""The numbers that the HCSS paper prints, from the data of the plugin hcss-paper."""

import json
from pathlib import Path

DATA = Path(__file__).parents[1] / "plugins" / "hcss-paper" / "src" / "hcss_paper" / "data"
PAPER = json.loads((DATA / "tables.json").read_text(encoding="utf-8"))
