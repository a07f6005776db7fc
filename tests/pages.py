"""Reading of HTML reports in tests: what is well-formed, what is shown, what is asked for from elsewhere."""

import base64
import io
import json
import re
from html.parser import HTMLParser

import numpy as np
from PIL import Image

VOID = {"meta", "img", "br", "input", "link", "hr"}
DRAWN_BY_SVG = {"rect", "line", "circle", "polygon", "path"}


class Reader(HTMLParser):
    """Checks that elements are closed in order, and collects texts, tables, addresses and elements of drawings."""

    def __init__(self):
        super().__init__()
        self.open, self.addresses, self.elements, self.tables, self.texts = [], [], [], [], []
        self.ids = []

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        assert len(attributes) == len(attrs), f"an attribute of <{tag}> is there twice"
        self.elements.append((tag, attributes))
        self.addresses += [value for name, value in attrs if name in {"src", "href", "srcset", "action", "data"}]
        self.ids += [attributes["id"]] if "id" in attributes else []
        if tag not in VOID:
            self.open.append(tag)
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append([])
        elif tag in {"td", "th"}:
            self.tables[-1][-1].append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] not in {"script", "style"}:
            self.texts.append(data)
        if {"td", "th"} & set(self.open):
            self.tables[-1][-1][-1] += data

    @property
    def text(self):
        return "".join(self.texts)

    def table(self, *header):
        """Rows of the table that begins with this header, without it."""
        found = [each for each in self.tables if each[0][: len(header)] == list(header)]
        assert len(found) == 1, f"{len(found)} tables begin with {header}"
        return found[0][1:]


def read_page(path):
    """Read a page; fails where it is not well-formed or asks for anything from elsewhere."""
    text = path.read_text(encoding="utf-8")
    found = Reader()
    found.feed(text)
    found.close()
    assert found.open == []
    assert len(set(found.ids)) == len(found.ids)
    assert all(address.startswith(("data:", "#")) for address in found.addresses)
    assert not re.search(r"@import|url\((?!data:)|fetch\(|XMLHttpRequest|WebSocket", text)
    assert not {"link", "iframe", "object", "embed"} & {tag for tag, _ in found.elements}
    return found


def view_of(path):
    """What the script of a cube's page has of frames; pictures as arrays of levels, the first row in the south."""
    text = path.read_text(encoding="utf-8")
    view = json.loads(re.search(r"const VIEW = (\{.*\});\n", text)[1].replace("<\\!", "<!"))
    stills = [
        attributes["src"].partition(",")[2]
        for tag, attributes in read_page(path).elements
        if tag == "img" and "first frame" in attributes.get("alt", "")
    ]
    assert len(stills) == len(view["quantities"][0]["parts"])
    for still, part in zip(stills, view["quantities"][0]["parts"], strict=True):
        assert part["pictures"][0] == ""
        part["pictures"][0] = still
    for quantity in view["quantities"]:
        for part in quantity["parts"]:
            part["png"] = part["pictures"]
            part["pictures"] = [levels(picture) for picture in part["png"]]
    return {each["name"]: each for each in view["quantities"]} | {"frames": view["frames"]}


def levels(picture):
    with Image.open(io.BytesIO(base64.b64decode(picture))) as image:
        assert image.mode == "P"
        return np.asarray(image)[::-1]


def ends(bar):
    """Lowest and highest value of a colour bar."""
    found = re.search(r'class="ends">(\S+) to ([^\s<;]+)', bar)
    return float(found[1]), float(found[2])


def ticks(bar):
    """Values at the ticks of a colour bar, with their shares of its length."""
    return [
        (float(value), float(percent) / 100.0)
        for percent, value in re.findall(r'<span style="left:([\d.]+)%"[^>]*>([^<]*)</span>', bar)
    ]
