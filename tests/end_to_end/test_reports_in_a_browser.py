"""Pages in a real browser without a screen: what is asked for is shown, on phones and on paper, without a complaint."""

import base64
import json
import re
import shutil
import subprocess

import pytest
from cheap import CHEAP, NARROW
from pages import Reader, view_of
from test_cube_report import written

import hcss_twin
from hcss_twin.cube.requested_variables import expand

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)

pytestmark = [
    pytest.mark.skipif(BROWSER is None, reason="no chromium, chromium-browser or google-chrome is installed"),
    pytest.mark.long,
]

VARIABLES = ["radiance", "brightness_temperature", "cloud_mask", "cloud_top_altitude"]


class Shown(Reader):
    """The viewer's own attributes and texts, of a page as the browser has it."""

    def __init__(self, text):
        super().__init__()
        self.feed(text)
        self.viewer = next(each for _, each in self.elements if (each.get("class") or "").startswith("viewer"))
        self.state = tuple(self.viewer[f"data-{key}"] for key in ("quantity", "part", "frame"))
        stage = re.search(r'<div class="stage">.*?<div class="stills', text, re.DOTALL)[0]
        self.picture = re.search(r'<img src="data:image/png;base64,([^"]*)"', stage)[1]
        self.about = re.sub(r"<[^>]*>", "", re.search(r'<p class="about">.*?</p>', stage, re.DOTALL)[0])


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("browser")
    path = written(folder / "c.nc", frames=6, rows=20, columns=30, variables=tuple(expand(VARIABLES, {})))
    return hcss_twin.report(path)


def browse(page, folder, *options):
    """Run the browser once; returns its answer and what it complained about."""
    command = [
        BROWSER,
        "--headless=new",
        "--no-sandbox",
        "--disable-gpu",
        "--disable-extensions",
        "--hide-scrollbars",
        "--enable-logging=stderr",
        f"--user-data-dir={folder / 'profile'}",
        "--window-size=1200,900",
        "--virtual-time-budget=4000",
        *options,
        page,
    ]
    done = subprocess.run(command, capture_output=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr.decode(errors="replace")
    return done.stdout.decode(), [line for line in done.stderr.decode().splitlines() if "CONSOLE" in line]


def shown(page, folder, fragment="", script=""):
    """Return the page as it stands after a script of the test, which may be empty."""
    if script:
        changed = folder / "changed.html"
        text = page.read_text(encoding="utf-8")
        changed.write_text(text.replace("</body>", f"<script>{script}</script></body>"), encoding="utf-8")
        page = changed
    text, complaints = browse(f"file://{page}{fragment}", folder, "--dump-dom")
    assert complaints == []
    return Shown(text)


def expect(found, page, quantity, part, frame):
    view = view_of(page)
    one = view[quantity]
    data = next(each for each in one["parts"] if each["name"] == part)
    place = [view["frames"][each]["number"] for each in one["frames"]].index(frame)
    assert found.state == (quantity, part, str(frame))
    assert found.picture == data["png"][place]
    numbers = data["numbers"][place]
    assert f"frame {frame}, {view['frames'][one['frames'][place]]['time']}," in found.about
    assert f"mean {numbers['mean']}, lowest {numbers['lowest']}, highest {numbers['highest']}" in found.about


@pytest.mark.parametrize(
    ("fragment", "state"),
    [
        ("", ("brightness_temperature", None, 0)),
        ("#frame=3&band=1", ("brightness_temperature", "MWIR", 3)),
        ("#frame=5&band=MWIR&show=brightness_temperature", ("brightness_temperature", "MWIR", 5)),
        ("#show=cloud_mask&frame=2", ("cloud_mask", "", 2)),
        ("#frame=99&band=none&show=nothing", ("brightness_temperature", None, 5)),
    ],
)
def test_the_address_says_what_is_shown_and_without_one_the_band_with_most_to_see(page, tmp_path, fragment, state):
    quantity, part, frame = state
    expect(shown(page, tmp_path, fragment), page, quantity, opening(page)[0] if part is None else part, frame)


def opening(page):
    """Bands of the brightness temperature in the order of the page."""
    return [part["name"] for part in view_of(page)["brightness_temperature"]["parts"]]


def test_slider_switches_and_keys_show_what_they_say(page, tmp_path):
    steps = """
      const at = (what) => document.querySelector(what);
      const tell = (what, name) => at(what).dispatchEvent(new Event(name, {bubbles: true}));
      const press = (key) => at('.viewer').dispatchEvent(new KeyboardEvent('keydown', {key, bubbles: true}));
      const states = [];
      const note = () => states.push([at('.viewer').dataset.quantity, at('.viewer').dataset.part,
        Number(at('.viewer').dataset.frame), at('input[type=range]').value, location.hash]);
      at('input[type=range]').value = 4; tell('input[type=range]', 'input');
      tell('input[type=range]', 'change'); note();
      at('select.part').value = 1; tell('select.part', 'change'); note();
      at('select.quantity').value = 1; tell('select.quantity', 'change'); note();
      press('ArrowRight'); note(); press('ArrowRight'); note(); press('ArrowLeft'); note(); press('Home'); note();
      press('End'); note(); press('b'); note(); press('q'); note();
      document.body.dataset.states = JSON.stringify(states);
    """
    found = shown(page, tmp_path, script=steps)
    body = next(attributes for tag, attributes in found.elements if tag == "body")
    states = json.loads(body["data-states"])
    first, second = opening(page)
    radiance = [part["name"] for part in view_of(page)["radiance"]["parts"]]
    after = radiance[(radiance.index(second) + 1) % 2]
    assert [tuple(state[:3]) for state in states] == [
        ("brightness_temperature", first, 4),
        ("brightness_temperature", second, 4),
        ("radiance", second, 4),
        ("radiance", second, 5),
        ("radiance", second, 0),
        ("radiance", second, 5),
        ("radiance", second, 0),
        ("radiance", second, 5),
        ("radiance", after, 5),
        ("cloud_mask", "", 5),
    ]
    assert all(int(state[3]) == state[2] for state in states)
    assert states[2][4] == f"#frame=4&show=radiance&band={second}"
    expect(found, page, "cloud_mask", "", 5)


def test_it_plays_until_it_is_stopped(page, tmp_path):
    steps = """
      const seen = new Set();
      const button = document.querySelector('button.play');
      button.click();
      const watch = setInterval(() => seen.add(document.querySelector('.viewer').dataset.frame), 50);
      setTimeout(() => { button.click(); clearInterval(watch);
        document.body.dataset.seen = [...seen].sort().join(); document.body.dataset.word = button.textContent; }, 2500);
    """
    found = shown(page, tmp_path, script=steps)
    body = next(attributes for tag, attributes in found.elements if tag == "body")
    assert body["data-seen"] == "0,1,2,3,4,5"
    assert body["data-word"] == "Play"


def test_paper_has_the_frame_that_was_chosen_in_every_band(page, tmp_path):
    found = shown(page, tmp_path, "#frame=4", script="window.dispatchEvent(new Event('beforeprint'));")
    stills = [
        attributes["src"].partition(",")[2]
        for tag, attributes in found.elements
        if tag == "img" and "first frame" in attributes.get("alt", "")
    ]
    assert stills == [part["png"][4] for part in view_of(page)["brightness_temperature"]["parts"]]
    browse(f"file://{page}", tmp_path, "--no-pdf-header-footer", f"--print-to-pdf={tmp_path / 'page.pdf'}")
    content = (tmp_path / "page.pdf").read_bytes()
    assert content.startswith(b"%PDF")
    assert 1 < len(re.findall(rb"/Type\s*/Page\b", content)) < 15


def sweep_page(folder):
    from test_sweep_report import swept

    return hcss_twin.report(swept(folder / "out").folder)


def posterior_page(folder):
    from test_posterior_report import written as posterior

    return hcss_twin.report(posterior(folder / "posterior.nc"))


def propagation_page(folder):
    from hcss_uncertainty import propagate

    scene = CHEAP | {"image.rows": 36, "image.columns": 36, "frames.count": 1, "bands": NARROW}
    uncertain = {"sea.temperature": "normal:291:0.5", "clouds.coverage": "uniform:0.2:0.8"}
    path = folder / "propagation.nc"
    propagate("stratus", path, draws=8, uncertain=uncertain, overrides=scene)
    return hcss_twin.report(path)


@pytest.mark.parametrize("kind", ["cube", "sweep", "posterior", "propagation"])
def test_nothing_is_wider_than_a_phone_or_a_screen(page, tmp_path, kind):
    # windows of browsers are no narrower than 500 pixels, frames in a page may be
    widths = [390, 1190]
    pages = {"sweep": sweep_page, "posterior": posterior_page, "propagation": propagation_page}
    made = pages[kind](tmp_path) if kind in pages else page
    inner = base64.b64encode(made.read_bytes()).decode()
    frames = "".join(f"<iframe style='width:{width}px;height:800px;border:0'></iframe>" for width in widths)
    holder = tmp_path / "holder.html"
    holder.write_text(
        f"<!DOCTYPE html><body style='margin:0'>{frames}<script>const widths = [];"
        f"const bytes = Uint8Array.from(atob('{inner}'), (one) => one.charCodeAt(0));"
        "document.querySelectorAll('iframe').forEach((frame, number) => { frame.onload = () => {"
        " widths[number] = frame.contentDocument.documentElement.scrollWidth;"
        " document.body.dataset.widths = JSON.stringify(widths); };"
        " frame.srcdoc = new TextDecoder().decode(bytes); });</script></body>",
        encoding="utf-8",
    )
    text, complaints = browse(f"file://{holder}", tmp_path, "--dump-dom")
    assert complaints == []
    assert re.search(r'data-widths="([^"]*)"', text)[1] == str(widths).replace(" ", "")


def test_a_page_in_the_browser_asks_for_nothing(page, tmp_path):
    script = """
      const names = performance.getEntriesByType('resource').map((each) => each.name);
      document.body.dataset.asked = names.filter((name) => !name.startsWith('data:')).join();
    """
    found = shown(page, tmp_path, script=script)
    body = next(attributes for tag, attributes in found.elements if tag == "body")
    assert body["data-asked"] == ""


def test_a_complaint_of_the_browser_is_noticed(page, tmp_path):
    broken = tmp_path / "broken.html"
    broken.write_text(page.read_text(encoding="utf-8").replace("choose(0);", "chose(0);"), encoding="utf-8")
    _, complaints = browse(f"file://{broken}", tmp_path, "--dump-dom")
    assert len(complaints) == 1
    assert "chose is not defined" in complaints[0]
