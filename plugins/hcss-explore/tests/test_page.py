"""The page in a headless Chromium: what a user does with mouse and keyboard, and what they see."""

import base64
import json
import threading

import numpy as np
import pytest
from chromium import CHROMIUM, Chromium
from hcss_explore.explorer import Explorer
from hcss_explore.server import Server

from hcss_twin import Scenario, ScenarioError, simulate

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine: the page is not driven")


@pytest.fixture(scope="module")
def browser():
    with Chromium() as running:
        yield running


@pytest.fixture
def opened(browser, server):
    """The page with its first image and the spectrum of the pixel in the middle."""
    browser.errors.clear()
    browser.requests.clear()
    browser.scheme("light")
    browser.resize(1400, 950)
    browser.open(server.address)
    browser.until("document.body.dataset.frames >= 1 && state.pixel !== null")
    return browser


def values(browser):
    """Radiance (B, y, x) that the page shows."""
    text = browser.run(
        "btoa(Array.from(new Uint8Array(state.frame.radiance.slice().buffer), "
        "(byte) => String.fromCharCode(byte)).join(''))"
    )
    about = browser.run("state.frame.about")
    shape = len(about["bands"]), about["rows"], about["columns"]
    return np.frombuffer(base64.b64decode(text), "<f4").reshape(shape)


def write(browser, key, text):
    """Type into a control in place of what it holds."""
    browser.run(
        f"(() => {{ const input = places.get('{key}').input; input.closest('details').open = true; "
        "input.focus(); input.select(); })()"
    )
    if text:
        browser.type(text)
    else:
        browser.run("document.execCommand('delete')")


def wait_for(browser, script):
    """Wait for an image of which a condition holds."""
    browser.until(f"state.frame && !$('status').classList.contains('busy') && ({script})")


def test_the_page_loads_from_this_server_alone_and_without_errors(opened, server):
    assert opened.errors == []
    assert opened.requests
    assert all(address.startswith((server.address, "data:,")) for address in opened.requests)


def test_it_shows_image_histogram_spectrum_and_omissions(opened, explorer):
    picture = explorer.picture({}, 0, False)
    assert np.array_equal(values(opened), picture.radiance)
    for canvas in ("image", "marks", "scale", "histogram", "spectrum"):
        colours = opened.run(
            f"(({{ width, height }}, context) => new Set(new Uint32Array(context.getImageData(0, 0, width, height)"
            f".data.buffer)).size)($('{canvas}'), $('{canvas}').getContext('2d'))"
        )
        assert colours > 3, canvas
    shown = opened.run("$('omissions').innerText")
    sized = [omission for omission in picture.about["omissions"] if omission["size"] != 0]
    assert sized
    assert all(omission["what"] in shown and omission["needs"] in shown for omission in sized)
    assert f"{picture.kelvin[1, 12, 16]:.2f} K" in opened.run("$('pixel-bands').innerText")
    assert "sea emits" in opened.run("$('parts').innerText")
    assert all(text in opened.run("$('moments').textContent") for text in ("mean", "standard deviation"))


def test_the_first_row_of_the_image_is_the_northern_one(opened, explorer):
    kelvin = explorer.picture({}, 0, False).kelvin[1]
    opened.run("(() => { $('stretch').value = 'whole'; draw(); })()")
    drawn = opened.run(
        "Array.from($('image').getContext('2d').getImageData(0, 0, $('image').width, $('image').height).data)"
    )
    green = np.array(drawn).reshape(*kelvin.shape, 4)[..., 1]
    assert np.corrcoef(green.ravel(), kelvin[::-1].ravel())[0, 1] > 0.95


def test_colours_only_ever_rise_with_temperature(opened):
    for kind in ("both", "all", "clear", "cloud", "whole"):
        shares = opened.run(
            f"(() => {{ $('stretch').value = '{kind}'; "
            "const { low, high, share } = scaleOf(plane(state.frame.kelvin)); "
            "return Array.from({ length: 101 }, (_, step) => share(low + (step / 100) * (high - low))); })()"
        )
        assert shares[0] == pytest.approx(0.0, abs=1e-9)
        assert shares[-1] == pytest.approx(1.0, abs=1e-9)
        assert np.all(np.diff(shares) > 0.0)


def test_a_control_makes_a_new_plan_which_the_page_shows_being_made(opened, explorer):
    opened.run(
        "(() => { window.said = []; const note = new MutationObserver(() => said.push($('status').textContent)); "
        "note.observe($('status'), { childList: true }); })()"
    )
    write(opened, "view.zenith", "41")
    wait_for(opened, "Math.abs(state.frame.about.view_zenith_deg - 41) < 1e-9")
    said = opened.run("said.join('|')")
    assert "making a new plan" in said
    assert "computing its tables" in said
    assert np.array_equal(values(opened), explorer.picture({"view.zenith": "41"}, 0, False).radiance)
    opened.run("(() => { said.length = 0; $('frame').value = 2; $('frame').dispatchEvent(new Event('input')); })()")
    wait_for(opened, "state.frame.about.number === 2")
    assert "making a new plan" not in opened.run("said.join('|')")
    assert "plan and tables kept" in opened.run("$('cost').textContent")


def test_a_problem_is_shown_beside_its_control_in_the_words_of_the_core(opened, server):
    before = values(opened)
    write(opened, "view.zenith", "95")
    opened.until("places.get('view.zenith').error.textContent !== ''")
    with pytest.raises(ScenarioError) as error:
        Scenario.from_dict(server.explorer.raw, {"view.zenith": 95}, base=server.explorer.base)
    assert opened.run("places.get('view.zenith').error.textContent") == str(error.value.problems[0])
    assert opened.run("places.get('view.zenith').input.getAttribute('aria-invalid')") == "true"
    assert opened.run("document.querySelectorAll('[aria-invalid]').length") == 1
    assert np.array_equal(values(opened), before)
    write(opened, "others", "sea.temprature = 290")
    opened.until("places.get('others').error.textContent.includes('closest')")
    write(opened, "others", " ")
    write(opened, "view.zenith", "10")
    wait_for(opened, "Math.abs(state.frame.about.view_zenith_deg - 10) < 1e-9")
    assert opened.run("document.querySelectorAll('[aria-invalid]').length") == 0


def test_quick_changes_are_dropped_and_the_last_one_is_shown(opened, explorer):
    first = opened.run("Number(document.body.dataset.frames)")
    opened.run(
        "(async () => { const { input } = places.get('seed'); for (let seed = 100; seed < 140; seed++) { "
        "input.value = seed; input.dispatchEvent(new Event('input')); "
        "await new Promise((done) => setTimeout(done, 45)); } })()"
    )
    wait_for(opened, "state.frame.about.toml.includes('seed = 139')")
    assert opened.run("Number(document.body.dataset.frames)") - first < 40
    assert np.array_equal(values(opened), explorer.picture({"seed": "139"}, 0, False).radiance)


def test_a_scenario_saved_from_the_page_has_its_image(opened, folder):
    write(opened, "clouds.coverage", "0.35")
    write(opened, "sea.temperature", "")
    wait_for(opened, "state.frame.about.toml.includes('coverage = 0.35') && !state.frame.about.toml.includes('291.4')")
    shown = values(opened)
    opened.run("(() => { $('name').focus(); $('name').select(); })()")
    opened.type("from the page")
    opened.press("Enter")
    opened.until("$('saved').textContent.includes('hcss run')")
    cube = simulate(Scenario.load(folder / "from the page.toml"))
    assert np.array_equal(cube["radiance"].isel(time=0).to_numpy(), shown)


CONTROLS = """[...document.querySelectorAll('button, input, select, textarea, summary, [tabindex="0"]')]
  .filter((each) => !each.disabled && each.checkVisibility())
  .map((each, number) => each.dataset.number = `${number}`)"""
"""Numbers everything that a user may operate."""

FOCUS = """((focus) => {
  const shown = focus.closest('#bands label') ?? focus, box = shown.getBoundingClientRect();
  const over = document.elementFromPoint(box.left + box.width / 2, box.top + Math.min(box.height / 2, 20));
  return { number: focus.dataset.number ?? '', name: focus.id || focus.getAttribute('aria-label') || focus.textContent,
    is_marked: getComputedStyle(shown).outlineStyle !== 'none', is_free: shown.contains(over) }; })
  (document.activeElement)"""
"""Which control has the focus, whether it is marked, and whether nothing lies over it."""


def tab_to(browser, name):
    """Press Tab until a control has the focus."""
    for _ in range(90):
        browser.press("Tab")
        if browser.run(FOCUS)["name"] == name:
            return
    pytest.fail(f"no focus on {name}")


@pytest.mark.parametrize("width", [1400, 390])
def test_tab_reaches_every_control_and_its_focus_is_seen(opened, width):
    opened.resize(width, 844)
    controls = opened.run(CONTROLS)
    opened.run("document.activeElement?.blur()")
    reached = {}
    for _ in range(len(controls) + 10):
        opened.press("Tab")
        focus = opened.run(FOCUS)
        reached.setdefault(focus["number"], focus)
    left = opened.run(f"{json.dumps(sorted({*controls} - {*reached}))}.map((number) => "
                      "document.querySelector(`[data-number='${number}']`).type)")  # fmt: skip
    assert set(left) <= {"radio"}  # arrow keys choose one of a group
    seen = {number: focus["is_marked"] and focus["is_free"] for number, focus in reached.items() if number}
    assert [reached[number]["name"] for number in seen if not seen[number]] == []


def test_a_scenario_is_made_and_saved_with_the_keyboard_alone(opened, folder):
    opened.run("document.activeElement?.blur()")
    tab_to(opened, "Cover, slider")
    opened.press("ArrowRight")
    wait_for(opened, "state.frame.about.toml.includes('coverage = 0.51')")
    tab_to(opened, "picture")
    opened.press("ArrowUp")
    opened.press("ArrowRight", shift=True)
    assert opened.run("state.pick") == {"row": 13, "column": 26}
    opened.until("state.pixel && state.pixel.column === 26")
    opened.press("Home")
    assert opened.run("state.pick") == {"row": 12, "column": 16}
    for _ in range(6):  # back to the bands
        opened.press("Tab", shift=True)
        if opened.run("document.activeElement.name") == "band":
            break
    before = opened.run("state.band")
    opened.press("ArrowRight")
    assert opened.run("state.band") != before
    tab_to(opened, "name")
    opened.press("Enter")
    opened.until("$('saved').textContent.includes('hcss run')")
    assert Scenario.load(folder / "explored.toml").clouds.layers[0].coverage == 0.51


CONTRAST = """(() => {
  const light = (text) => { const parts = text.match(/[\\d.]+/g).slice(0, 3).map((part) => part / 255)
    .map((part) => (part <= 0.03928 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4));
    return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2]; };
  const probe = document.body.appendChild(document.createElement('i'));
  const of = (name) => { probe.style.color = `var(--${name})`; return light(getComputedStyle(probe).color); };
  const ratio = (one, other) => (Math.max(one, other) + 0.05) / (Math.min(one, other) + 0.05);
  const inks = ['ink', 'quiet', 'accent', 'bad', 'warn'];
  const least = Math.min(...inks.flatMap((ink) => ['page', 'panel'].map((paper) => ratio(of(ink), of(paper)))));
  probe.remove();
  return least; })()"""
"""The least contrast of text, as WCAG 2 defines it."""

CUT = """[...document.querySelectorAll('main > *, .control .row > *, canvas, table')].filter((each) => each.offsetParent
  && each.getBoundingClientRect().right > document.documentElement.clientWidth + 1)
  .map((each) => each.outerHTML.slice(0, 80))"""
"""What reaches beyond the window."""


def test_nothing_leaves_the_page_wide_and_narrow_or_is_too_pale_in_either_scheme(opened):
    for width in (1600, 1000, 380):
        opened.resize(width, 900)
        opened.until(f"innerWidth === {width} && document.documentElement.scrollWidth <= innerWidth", 10.0)
        assert opened.run(CUT) == [], width
    for scheme in ("light", "dark"):
        opened.scheme(scheme)
        assert opened.run(CONTRAST) >= 4.5
        paper = json.loads(
            opened.run("getComputedStyle(document.body).backgroundColor").replace("rgb(", "[").replace(")", "]")
        )
        assert (max(paper) < 100) == (scheme == "dark")


def test_a_run_is_shown_as_hcss_run_says_it(opened):
    write(opened, "frames.count", "1")
    opened.run("$('run').click()")
    opened.until("$('run-state').textContent.includes('exit code')")
    assert opened.run("$('said').textContent").startswith("scene.nc")
    write(opened, "frames.count", "5000")  # so that it still runs when a busy machine comes to stop it
    opened.run("$('run').click()")
    opened.until("!$('stop').hidden")
    opened.run("$('stop').click()")
    opened.until("$('run-state').textContent === 'stopped' && !$('run').disabled")


def test_an_ended_server_is_named(browser, folder):
    with Server(Explorer(str(folder / "scene.toml"))) as running:
        thread = threading.Thread(target=running.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        browser.open(running.address)
        browser.until("document.body.dataset.frames >= 1 && state.pixel !== null")
        running.shutdown()
        thread.join()
    write(browser, "seed", "8")
    browser.until("$('status').classList.contains('bad')")
    assert "no answer" in browser.run("$('status').textContent")
