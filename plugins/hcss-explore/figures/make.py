"""Draw page.png of the README: ``python plugins/hcss-explore/figures/make.py`` (needs chromium)."""

import io
import sys
import threading
from pathlib import Path

from hcss_explore.explorer import Explorer
from hcss_explore.server import Server
from PIL import Image

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))

from chromium import Chromium  # noqa: E402

COLOURS = 256
"""Of the picture, so that it stays below 150 kB."""


def main() -> None:
    """Open the page of the scenario stratus, pick a cloudy pixel, and write what it shows."""
    with Server(Explorer("stratus")) as server, Chromium(1280, 860) as browser:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        browser.open(server.address)
        browser.until("document.body.dataset.frames >= 1")
        browser.run("pick(70, 110)")
        browser.until("!!state.pixel && state.pixel.row === 70")
        path = HERE / "page.png"
        browser.screenshot(path)
        with Image.open(io.BytesIO(path.read_bytes())) as picture:
            few = picture.convert("RGB").quantize(COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
            few.save(path, optimize=True)
        server.shutdown()
    print(f"{path}: {path.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
