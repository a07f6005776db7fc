"""What the server lets in, and how it answers many at once; without a browser."""

import http.client
import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import suppress

import numpy as np
import pytest
from conftest import changed
from frames import read_frame
from hcss_explore.server import LARGEST_REQUEST, Dropped, Newest

from hcss_twin import Scenario, ScenarioError, simulate


def test_only_who_knows_the_token_gets_an_answer(asked, server):
    for token in ("", "x", server.token[:-1], server.token + "x", server.token.swapcase(), "%C3%A9"):
        for body in (None, changed()):
            answer = asked("about" if body is None else "frame", body, token=token)
            assert answer.status == 403
            assert server.token.encode() not in answer.content
    assert asked("about").status == 200
    assert len(server.token) >= 32


@pytest.mark.parametrize(
    "host", ["example.org", "127.0.0.1", "127.0.0.1:1", "", "localhost.example.org:{port}", "0.0.0.0:{port}"]
)
def test_other_names_of_this_machine_are_refused(asked, server, host):
    assert asked("about", Host=host.format(port=server.server_port)).status == 403
    assert asked("frame", changed(), Host=host.format(port=server.server_port)).status == 403


def test_its_own_names_are_not(asked, server):
    for name in ("127.0.0.1", "localhost"):
        host = f"{name}:{server.server_port}"
        assert asked("about", Host=host, Origin=f"http://{host}").status == 200


@pytest.mark.parametrize("origin", ["http://example.org", "null", "https://127.0.0.1:{port}", "http://127.0.0.1:1", ""])
def test_pages_of_other_sites_are_refused(asked, server, origin):
    origin = origin.format(port=server.server_port)
    assert asked("frame", changed(), Origin=origin).status == 403
    assert asked("save", {**changed(), "name": "theirs"}, Origin=origin).status == 403
    assert not (server.explorer.base / "theirs.toml").exists()


def test_it_listens_on_this_machine_alone(server):
    assert server.server_address[0] == "127.0.0.1"


def test_the_page_may_load_nothing_from_elsewhere_and_be_in_no_frame(asked):
    for path in ("", "page.css", "page.js", "about"):
        answer = asked(path)
        assert answer.status == 200
        policy = answer.headers["Content-Security-Policy"]
        assert "default-src 'none'" in policy
        assert "frame-ancestors 'none'" in policy
        assert answer.headers["Referrer-Policy"] == "no-referrer"
        assert answer.headers["Cache-Control"] == "no-store"
        if path != "about":
            assert not re.findall(rb"https?://|url\(|@import|innerHTML|eval\(", answer.content)


@pytest.mark.parametrize("path", ["nothing", "../pyproject.toml", "site/page.html", "%2e%2e/x", "page.html", "frame/"])
def test_there_are_no_other_files(asked, path):
    assert asked(path).status in (403, 404)
    assert asked(path, changed()).status in (403, 404)


BODIES = {
    "no JSON": (b"{", 400),
    "no table": (b"[1]", 400),
    "nothing": (b"", 400),
    "no text": (b"\xff\xfe", 400),
    "deep": (b"[" * 50_000, 400),
    "too long": (b" " * (LARGEST_REQUEST + 1), 413),
    "no page": (b'{"changes": {}}', 400),
    "no changes": (b'{"page": "a", "changes": []}', 400),
    "number": (b'{"page": "a", "changes": {}, "number": "x"}', 400),
}


@pytest.mark.parametrize("name", BODIES)
def test_malformed_requests_are_refused_with_what_is_allowed(asked, name):
    body, status = BODIES[name]
    answer = asked("frame", body, Content_Type="application/json")
    assert answer.status == status
    assert answer.content.decode().strip()
    assert b"Traceback" not in answer.content


def test_forms_of_other_pages_are_refused(asked):
    body = json.dumps(changed()).encode()
    for kind in ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data", None):
        assert asked("frame", body, Content_Type=kind).status == 415


@pytest.mark.parametrize("method", ["PUT", "DELETE", "OPTIONS", "HEAD", "TRACE"])
def test_other_methods_are_refused(asked, method):
    assert asked("about", method=method).status == 501


@pytest.mark.parametrize(
    "text", [b"\0\0\0\0", b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"POST /x/frame HTTP/1.1\r\n\r\n", b"A" * 70_000]
)
def test_what_is_no_request_ends_nothing(asked, server, text):
    with socket.create_connection(("127.0.0.1", server.server_port), timeout=10) as connection:
        connection.sendall(text)
        connection.shutdown(socket.SHUT_WR)
        with suppress(ConnectionError):
            while connection.recv(65536):
                pass
    assert asked("about").status == 200


WRONG = [
    {"view.zenith": {"a": 1}},
    {"view.zenith": [1]},
    {"bands": "lwir"},
    {"bands": [[]]},
    {"..": "1"},
    {"seed[0]": "1"},
    {"seed.x": "1"},
    {"sensor": {"name": 1}},
    {"sensor": "nothing"},
    {"others": "no assignment"},
    {"others": {"a": 1}},
    {"clouds.type": "../../x.toml"},
    {"frames.count": "1e400"},
    {"image.rows": "100000", "image.columns": "100000"},
    {"output.variables": ["nothing"]},
    {"time": "2024"},
]


def test_whatever_the_controls_hold_the_answer_names_the_problem(asked):
    for changes in WRONG:
        answer = asked("frame", {"page": "a", "changes": changes})
        assert answer.status == 200
        _, found, radiance, _ = read_frame(answer.content)
        assert radiance is None, changes
        assert found["problems"], changes
        assert all(problem["message"] for problem in found["problems"])
    assert read_frame(asked("frame", changed()).content)[2] is not None


def test_a_problem_is_told_in_the_words_of_the_core(asked, server):
    _, found, _, _ = read_frame(asked("frame", changed(view__zenith="95")).content)
    with pytest.raises(ScenarioError) as error:
        Scenario.from_dict(server.explorer.raw, {"view.zenith": 95}, base=server.explorer.base)
    assert found["problems"] == [vars(problem) for problem in error.value.problems]


def test_of_requests_that_wait_only_the_newest_of_a_page_is_computed():
    newest, computed = Newest(), []
    entered, leave = threading.Event(), threading.Event()

    def slow(check):
        entered.set()
        leave.wait(30.0)
        check()
        computed.append("first")

    def ask(name, wanted, work):
        try:
            newest.compute(wanted, work)
        except Dropped:
            computed.append(f"{name} dropped")

    threads = [threading.Thread(target=ask, args=("first", newest.ask("a", "frame"), slow))]
    threads[0].start()
    assert entered.wait(30.0)
    for number in range(5):
        wanted = newest.ask("a", "frame")
        threads.append(
            threading.Thread(target=ask, args=(number, wanted, lambda check, number=number: computed.append(number)))
        )
        threads[-1].start()
    other = newest.ask("b", "frame")
    threads.append(threading.Thread(target=ask, args=("b", other, lambda check: computed.append("other page"))))
    threads[-1].start()
    leave.set()
    for thread in threads:
        thread.join(30.0)
    assert sorted(map(str, computed)) == [
        "0 dropped",
        "1 dropped",
        "2 dropped",
        "3 dropped",
        "4",
        "first dropped",
        "other page",
    ]


def test_a_page_whose_request_waits_long_for_another_is_told_so_before_its_turn(server):
    begun, told = threading.Event(), threading.Event()

    def work(_check):
        begun.set()
        told.wait(30.0)

    other = threading.Thread(target=server.newest.compute, args=(lambda: True, work))
    other.start()
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=20)
    try:
        assert begun.wait(30.0)
        body = json.dumps(changed(seed="6"))
        connection.request("POST", f"/{server.token}/frame", body, {"Content-Type": "application/json"})
        answer = connection.getresponse()
        assert json.loads(answer.readline()) == {"stage": "turn"}
        told.set()
        assert read_frame(answer.read())[0] == ["plan", "tables", "frame"]
    finally:
        told.set()
        other.join(30.0)
        connection.close()


def test_a_newer_frame_ends_the_spectrum_of_its_page_and_of_no_other():
    newest = Newest()
    mine, other = newest.ask("a", "pixel"), newest.ask("b", "pixel")
    frame = newest.ask("a", "frame")
    assert (mine(), other(), frame()) == (False, True, True)
    assert newest.ask("a", "pixel")()
    assert frame()
    newest.close()
    assert not frame()


def test_pages_that_ask_at_once_all_get_their_own_images(asked, server):
    seeds, found = range(4), {}

    def ask(seed):
        found[seed] = read_frame(asked("frame", {"page": f"page {seed}", "changes": {"seed": str(seed)}}).content)[2]

    threads = [threading.Thread(target=ask, args=(seed,)) for seed in seeds]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(120.0)
    for seed in seeds:
        scenario = Scenario.from_dict({**server.explorer.raw, "seed": seed}, base=server.explorer.base)
        assert np.array_equal(simulate(scenario)["radiance"].isel(time=0).to_numpy(), found[seed])


def test_a_page_that_goes_away_ends_nothing(asked, server, capfd):
    body = json.dumps(changed(seed="77")).encode()
    with socket.create_connection(("127.0.0.1", server.server_port), timeout=10) as connection:
        head = (
            f"POST /{server.token}/frame HTTP/1.1\r\nHost: 127.0.0.1:{server.server_port}\r\n"
            f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n"
        )
        connection.sendall(head.encode() + body)
    assert read_frame(asked("frame", changed()).content)[2] is not None
    assert capfd.readouterr().err == ""


def test_a_session_writes_the_saved_scenario_and_nothing_else(asked, server, folder, monkeypatch, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    monkeypatch.chdir(elsewhere)
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*")}
    stages, about, _, kelvin = read_frame(asked("frame", {**changed(seed="505"), "number": 1}).content)
    assert [stage for stage in stages if stage != "turn"] == ["plan", "tables", "frame"]
    assert np.nanmin(kelvin) > 150.0
    pixel = asked("pixel", {**changed(seed="505"), "number": 1, "row": 2, "column": 3, "band": 1})
    assert json.loads(pixel.content)["row"] == 2
    asked("about")
    saved = json.loads(asked("save", {**changed(seed="505"), "name": "kept"}).content)
    assert saved == {"path": str(folder / "kept.toml")}
    assert (folder / "kept.toml").read_text(encoding="utf-8") == about["toml"]
    after = {path: path.stat().st_mtime_ns for path in folder.rglob("*")}
    assert after.pop(folder / "kept.toml")
    assert after == before
    assert list(elsewhere.iterdir()) == []


def test_the_command_prints_the_address_and_ends_with_an_interrupt(folder):
    command = [sys.executable, "-m", "hcss_twin", "explore", "scene.toml", "--set", "seed=4", "--no-browser"]
    process = subprocess.Popen(
        command,
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    try:
        line = process.stdout.readline()
        found = re.fullmatch(r"exploring scene\.toml at http://127\.0\.0\.1:(\d+)/([\w-]+)/\n", line)
        assert found, line + process.stderr.read()
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        said, errors = process.communicate(timeout=60)
    finally:
        process.kill()
        process.wait()
    assert (process.returncode, errors) == (0, "")
    assert "ended" in said
