"""Run the tutorials: every file, command and script of a page, in order, in an empty folder.

::

    python docs/tutorials/run.py                        # all pages: report where the output differs from the page
    python docs/tutorials/run.py student.md --write     # write the output into the page

Code blocks of a page are:

* after a line that ends in "`name`:", the content of that file;
* otherwise ``sh``, run by bash, or ``python``, run as a script;
* ``text`` directly after a block that was run: its expected output, with numbers to 1 %.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import sysconfig
import tempfile
import venv
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).parent
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"`([\w./-]+)`:\s*\Z")
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?(?![\w])|(?<![\w])[-+]?\.\d+")
TOLERANCE = 0.01


@dataclass(frozen=True)
class Block:
    """One code block of a page: language, text, name of the file it defines, and offset of its text."""

    language: str
    text: str
    file: str | None
    start: int

    @property
    def runs(self) -> bool:
        """Whether the block is run rather than written to a file."""
        return self.file is None and self.language in ("sh", "python")


@dataclass(frozen=True)
class Ran:
    """A block that was run, its output, and the block with the expected output."""

    block: Block
    printed: str
    shown: Block | None


def blocks(page: str) -> list[Block]:
    """Return the code blocks of a page in order."""
    found = []
    for match in FENCE.finditer(page):
        before = page[: match.start()].rstrip("\n")
        file = FILE.search(before)
        found.append(Block(match[1], match[2], file[1] if file else None, match.start(2)))
    return found


def run(page: str, folder: Path, environment: dict[str, str]) -> Iterator[Ran]:
    """Run a page in a folder; raise RuntimeError if a block fails."""
    every = blocks(page)
    for name in ("docs", "plugins", "catalogs"):  # for pages that use files of the checkout
        (folder / name).symlink_to(FOLDER.parents[1] / name)
    for place, block in enumerate(every):
        if block.file is not None:
            target = folder / block.file
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(block.text, encoding="utf-8")
        elif block.runs:
            command = ["bash", "-euo", "pipefail", "-c"] if block.language == "sh" else ["python", "-c"]
            done = subprocess.run(
                [*command, block.text],
                cwd=folder,
                env=environment,
                capture_output=True,
                text=True,
                timeout=600,
                check=False,
            )
            if done.returncode:
                raise RuntimeError(f"exit code {done.returncode} of\n{block.text}\n{done.stdout}{done.stderr}")
            after = every[place + 1] if place + 1 < len(every) else None
            shown = after if after and after.language == "text" and after.file is None else None
            yield Ran(block, done.stdout, shown)


def same(shown: str, printed: str) -> bool:
    """Whether two outputs agree: words exactly, numbers to 1 %, ignoring white space."""
    if NUMBER.sub("#", " ".join(shown.split())) != NUMBER.sub("#", " ".join(printed.split())):
        return False
    pairs = zip(NUMBER.findall(shown), NUMBER.findall(printed), strict=True)
    return all(
        abs(float(one) - float(other)) <= TOLERANCE * max(abs(float(one)), abs(float(other))) for one, other in pairs
    )


def environment(folder: Path) -> dict[str, str]:
    """Create a virtual environment to install into, and return its environment variables.

    It sees the packages of the current environment. Its ``pip`` works offline, so a page that installs a package
    needs hatchling in the current environment.
    """
    root = str(FOLDER.parents[1])
    home = folder / "env"
    venv.create(home, with_pip=False)
    python = home / "bin" / "python"
    borrowed = {sysconfig.get_path("purelib"), sysconfig.get_path("platlib"), root}
    site = Path(sysconfig.get_path("purelib", "venv", {"base": str(home), "platbase": str(home)}))
    (site / "borrowed.pth").write_text("\n".join(sorted(borrowed)) + "\n", encoding="utf-8")
    offline = "--no-index --no-deps --no-build-isolation"
    for name, command in {
        "hcss": f'"{python}" -m hcss_twin "$@"',
        "pip": f'"{sys.executable}" -m pip --python "{python}" "$@" {offline}',
    }.items():
        script = home / "bin" / name
        script.write_text(f"#!/bin/sh\nexec {command}\n", encoding="utf-8")
        script.chmod(0o755)
    path = os.pathsep.join([str(home / "bin"), os.environ.get("PATH", "")])
    others = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}
    return others | {"PATH": path, "PYTHONPATH": root, "MPLBACKEND": "Agg"}


def refreshed(page: str, ran: list[Ran]) -> str:
    """Return the page with the actual output."""
    for each in reversed(ran):
        if each.shown:
            end = each.shown.start + len(each.shown.text)
            page = page[: each.shown.start] + each.printed.rstrip("\n") + "\n" + page[end:]
    return page


def main(arguments: list[str]) -> int:
    """Run pages; return 1 if any output differs."""
    write = "--write" in arguments
    names = [name for name in arguments if name != "--write"] or sorted(p.name for p in FOLDER.glob("*.md"))
    failed = 0
    for name in names:
        path = FOLDER / Path(name).name
        page = path.read_text(encoding="utf-8")
        with tempfile.TemporaryDirectory() as aside, tempfile.TemporaryDirectory() as folder:
            ran = list(run(page, Path(folder), environment(Path(aside))))
        different = [each for each in ran if each.shown and not same(each.shown.text, each.printed)]
        print(f"{path.name}: {len(ran)} blocks run, {len(different)} outputs differ")
        if write:
            path.write_text(refreshed(page, ran), encoding="utf-8")
            continue
        for each in different:
            print(f"--- shown\n{each.shown.text if each.shown else ''}--- printed\n{each.printed}")
        failed += len(different)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
