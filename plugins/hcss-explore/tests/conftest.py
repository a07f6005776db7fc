"""A small scene, an explorer of it, and its server; the cache of the tests is their own."""

import http.client
import json
import sys
import threading
from pathlib import Path
from types import SimpleNamespace

import pytest
from hcss_author.own_cache import own_cache  # noqa: F401
from hcss_explore.explorer import Explorer
from hcss_explore.server import Server

sys.path.insert(0, str(Path(__file__).parent))

SCENE = """\
title = "A small scene"
seed = 3
time = 2024-04-20T12:30:00+10:00
bands = [{name = "mwir", limits = [3.6, 3.8]}, {name = "lwir", limits = [10.5, 11.0]}]

[place]
latitude = 35.0
longitude = 150.0

[view]
zenith = 20.0
azimuth = 18.0

[image]
rows = 24
columns = 32
pixel_size = 60.0

[frames]
count = 3

[atmosphere]
profile = "profile.csv"

[clouds]
type = "stratus"
coverage = 0.5
parameters = {H = 0.6}

[sea]
model = "cox-munk"
wind_speed = 7.0
temperature = 291.4
temperature_texture = 0.0

[slant]
shadows = "off"
parallax = "off"

[optics]
provider = "mie"

[radiance]
model = "as-printed"
"""
"""Models that compile in a tenth of a second, and a file that is found beside the scenario only."""

PROFILE = """\
altitude_km,pressure_hPa,temperature_K,h2o_ppmv
0,1013.25,291.4,12000
2,800,280,5000
5,540,256,900
10,265,223,60
15,121,217,8
20,55,217,5
"""


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """A folder with scene.toml and the profile it names, for all tests: what they save has names of its own."""
    path = tmp_path_factory.mktemp("scenarios")
    (path / "scene.toml").write_text(SCENE, encoding="utf-8")
    (path / "profile.csv").write_text(PROFILE, encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def explorer(folder):
    """An explorer of the small scene."""
    return Explorer(str(folder / "scene.toml"))


@pytest.fixture(scope="session")
def server(explorer):
    """Its server, which runs."""
    with Server(explorer) as running:
        thread = threading.Thread(target=running.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        yield running
        running.shutdown()
        thread.join()


@pytest.fixture(scope="session")
def asked(server):
    """A function that sends a request: path below the token, body (a table, bytes or None) and headers."""

    def ask(path, body=None, token=None, method=None, **headers):
        connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=120)
        content = json.dumps(body).encode() if isinstance(body, dict) else body
        named = {"Content-Type": "application/json"} if isinstance(body, dict) else {}
        named |= {name.replace("_", "-"): value for name, value in headers.items()}
        connection.request(
            method or ("GET" if body is None else "POST"),
            f"/{server.token if token is None else token}/{path}",
            content,
            {name: value for name, value in named.items() if value is not None},
        )
        answer = connection.getresponse()
        found = SimpleNamespace(status=answer.status, headers=answer.headers, content=answer.read())
        connection.close()
        return found

    return ask


def changed(**changes):
    """The body of a request with controls by key, dots written as __."""
    return {"page": "test", "changes": {key.replace("__", "."): value for key, value in changes.items()}}
