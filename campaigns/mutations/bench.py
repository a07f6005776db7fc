"""A copy of the tree on which one mutation at a time is tried, with caches that know of it."""

from __future__ import annotations

import hashlib
import importlib.util
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from functions import PACKAGE, functions

HERE = Path(__file__).parent
LEFT = ("__pycache__", ".git", ".venv", ".mypy_cache", ".ruff_cache", ".pytest_cache", ".hypothesis", "rows*.json")


class Bench:
    """A copy of ``root`` in ``work``; the number tells several apart."""

    def __init__(self, root: Path, work: Path, number: int) -> None:
        self.work = work
        self.tree, self.kernels = work / f"tree-{number}", work / f"numba-{number}"
        shutil.rmtree(self.tree, ignore_errors=True)
        # Times of change are copied, too: what numba keeps of unchanged files stays valid.
        shutil.copytree(root, self.tree, ignore=shutil.ignore_patterns(*LEFT))
        self.functions = functions(self.tree)
        self._changed = work / f"changed-{number}.json"
        if self._changed.exists():  # an earlier run was interrupted
            self._remove_kernels(set(json.loads(self._changed.read_text(encoding="utf-8"))))

    @property
    def fingerprint(self) -> str:
        """Of all code and tests."""
        files = sorted([*(self.tree / PACKAGE).rglob("*.py"), *(self.tree / "tests").rglob("*.py")])
        return hashlib.sha256(b"".join(each.read_bytes() for each in files)).hexdigest()

    def watch(self, files: Sequence[str], functions: Mapping[str, object], found: Path) -> None:
        """Run files of tests and note what they reach: see reach_plugin.py."""
        wanted = self.work / "functions.json"
        wanted.write_text(json.dumps(functions), encoding="utf-8")
        names = {"HCSS_REACH_FUNCTIONS": str(wanted), "HCSS_REACH_FOUND": str(found)}
        code, text = self._pytest(["-p", "reach_plugin", *files], None, names)
        if not found.exists():
            raise RuntimeError(f"pytest ended with {code}:\n{text[-4000:]}")

    @contextmanager
    def changed(self, file: str, text: str) -> Iterator[None]:
        """Have another text in a file, and no compiled code of what was there or of files that use it."""
        path = self.tree / file
        before, times = path.read_bytes(), path.stat()
        stems = {Path(each).stem for each in self._users(file)}
        self._changed.write_text(json.dumps(sorted(stems)), encoding="utf-8")
        aside = self.work / f"{self.kernels.name}-aside"
        shutil.rmtree(aside, ignore_errors=True)
        aside.mkdir(parents=True)
        known = self._kernels_of(stems)
        for number, each in enumerate(known):
            each.replace(aside / str(number))
        compiled = Path(importlib.util.cache_from_source(str(path)))
        compiled.unlink(missing_ok=True)
        path.write_text(text, encoding="utf-8")
        try:
            yield
        finally:
            path.write_bytes(before)
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
            compiled.unlink(missing_ok=True)
            self._remove_kernels(stems)
            for number, each in enumerate(known):
                (aside / str(number)).replace(each)

    def judge(self, tests: Sequence[str], limit_s: float) -> tuple[str, str]:
        """Run tests until one fails: its outcome, and the name of that test.

        Returns
        -------
        outcome : str
            ``survived``, ``killed``, ``timeout``, ``interrupted`` (by a signal from outside) or ``error``.
        by : str
            The test that failed; of an error, the end of what pytest said.
        """
        code, text = self._pytest(["-x", *tests], limit_s, {})
        if code is None:
            return "timeout", ""
        if code == 0:
            return "survived", ""
        if code in (-signal.SIGTERM, -signal.SIGINT, -signal.SIGKILL, 2 if "KeyboardInterrupt" in text else -1):
            return "interrupted", ""
        if code < 0:
            return "killed", f"crash with signal {-code}"
        failed = re.findall(r"^(?:FAILED|ERROR) (tests/.*?)(?: - .*)?$", text, re.MULTILINE)
        return ("killed", failed[0]) if failed else ("error", text[-500:])

    def names(self, arguments: Sequence[str]) -> set[str]:
        """Names of the tests that pytest would run."""
        code, text = self._pytest(["--collect-only", *arguments], None, {})
        if code:
            raise RuntimeError(f"pytest ended with {code}:\n{text[-4000:]}")
        return {line for line in text.splitlines() if "::" in line and not line.startswith(("SKIPPED", "ERROR"))}

    def _kernels_of(self, stems: set[str]) -> list[Path]:
        """What numba keeps of files of these names."""
        return [each for each in self.kernels.rglob("*.nb[ic]") if each.name.partition(".")[0] in stems]

    def _remove_kernels(self, stems: set[str]) -> None:
        for each in self._kernels_of(stems):
            each.unlink()
        self._changed.unlink(missing_ok=True)

    def _users(self, file: str) -> set[str]:
        """The file and those whose compiled code may contain its own: files with kernels that import it, and so on."""
        kernels = {each.file for each in self.functions if each.compiled}
        texts = {
            each.relative_to(self.tree).as_posix(): each.read_text(encoding="utf-8")
            for each in (self.tree / PACKAGE).rglob("*.py")
        }
        found, todo = {file}, [file]
        while todo:
            module = todo.pop().removesuffix(".py").removesuffix("/__init__").replace("/", ".")
            package, _, name = module.rpartition(".")
            # import package.module, from package.module import ..., from package import module
            forms = (
                rf"{module} import",
                rf"{package} import [^(\n]*\b{name}\b",
                rf"{package} import \([^)]*\b{name}\b",
            )
            uses = re.compile(rf"^\s*(?:from (?:{'|'.join(forms)})|import {module}\b)", re.MULTILINE)
            for each, text in texts.items():
                if each not in found and (each in kernels or each.endswith("__init__.py")) and uses.search(text):
                    found.add(each)
                    todo.append(each)
        return found

    def _pytest(
        self, arguments: Sequence[str], limit_s: float | None, more: Mapping[str, str]
    ) -> tuple[int | None, str]:
        options = ["-q", "-rfE", "-p", "no:cacheprovider"]
        environment = {name: value for name, value in os.environ.items() if name != "HCSS_CACHE_DIR"}
        environment |= {"PYTHONPATH": f"{self.tree}{os.pathsep}{HERE}", "NUMBA_CACHE_DIR": str(self.kernels), **more}
        process = subprocess.Popen(
            [sys.executable, "-m", "pytest", *options, *arguments],
            cwd=self.tree,
            env=environment,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            text, _ = process.communicate(timeout=limit_s)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            return None, ""
        return process.returncode, text


def quick_tests(bench: Bench, options: str) -> set[str]:
    """Names of the tests of the quick subset, which pytest selects with some options."""
    return bench.names(shlex.split(options))
