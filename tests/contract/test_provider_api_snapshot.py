"""The public provider API is the one that was committed, and every change of it shows."""

import ast
import dataclasses
from pathlib import Path
from typing import Literal, Protocol

import pytest
from hcss_author import SeaModelContract
from provider_api_text import COMMAND, SNAPSHOT, api, broken_promises, described, kit, write

import hcss_twin
from hcss_twin import providers
from hcss_twin.providers import common as declared
from hcss_twin.providers.registry import Kind


def test_the_provider_api_is_the_committed_one():
    before, now = SNAPSHOT.read_text(encoding="utf-8").splitlines(), api()
    broken = broken_promises(before, now)
    new = [f"new: {line}" for line in now if line not in before]
    assert not broken, (
        f"version {providers.API_VERSION} of the provider API is frozen (docs/reference/provider-api.md), and this "
        "breaks plugins that are installed somewhere:\n"
        + "\n".join([*broken, *new])
        + "\nUndo it. If it must be, it is a new "
        f"version: raise API_VERSION in hcss_twin/providers/registry/specs.py, then {COMMAND}"
    )
    assert sorted(before) == sorted(now), (
        "the provider API has grown, which its version allows; it will have to stay:\n"
        + "\n".join(new)
        + f"\nIf that is meant, name it in CHANGELOG.md and write the snapshot: {COMMAND}"
    )


def test_lines_stand_for_themselves():
    lines = api()
    assert len(lines) == len(set(lines))
    assert not [line for line in lines if " at 0x" in line]


@dataclasses.dataclass(frozen=True)
class Toy:
    size: int
    shape: Literal["round", "long"] = "round"

    @property
    def area(self) -> float:
        return 1.0

    def grown(self, by: float, *, twice: bool = False) -> float:
        return 1.0


def changed(**namespace):
    """A class called Toy, with other contents."""
    body = {**{name: value for name, value in vars(Toy).items() if name in ("area", "grown")}, **namespace}
    body.setdefault("__annotations__", {"size": "int", "shape": Literal["round", "long"]})
    body.setdefault("shape", "round")
    return dataclasses.dataclass(frozen=True)(type("Toy", (), body))


def renamed(self, amount: float, *, twice: bool = False) -> float: ...


def optional(self, by: float | None, *, twice: bool = False) -> float: ...


def other_default(self, by: float, *, twice: bool = True) -> float: ...


def positional(self, by: float, twice: bool = False) -> float: ...


def other_result(self, by: float, *, twice: bool = False) -> int: ...


SHAPE = Literal["round", "long"]


@pytest.mark.parametrize(
    "breaking",
    [
        changed(__annotations__={"size": "float", "shape": SHAPE}),
        changed(__annotations__={"size": "int", "shape": Literal["round"]}),
        changed(shape="long"),
        changed(size=1),
        changed(__annotations__={"shape": SHAPE, "size": "int"}, size=1),
        changed(__annotations__={"shape": SHAPE}),
        changed(__annotations__={"size": "int", "colour": "str", "shape": SHAPE}),
        dataclasses.make_dataclass("Toy", [("size", "int"), ("shape", SHAPE, "round")]),
        *(changed(grown=each) for each in (renamed, optional, other_default, positional, other_result)),
        changed(area=lambda self: 1.0),
        changed(grown=None),
    ],
)
def test_a_changed_class_breaks_the_promise(breaking):
    assert broken_promises(described("Toy", Toy), described("Toy", breaking))


@pytest.mark.parametrize(
    "grown",
    [
        changed(),
        changed(__annotations__={"size": "int", "shape": SHAPE, "colour": "str"}, colour="white"),
        changed(shrunk=renamed),
    ],
)
def test_what_may_be_left_out_may_come(grown):
    assert broken_promises(described("Toy", Toy), described("Toy", grown)) == []


def test_a_required_member_may_not_come_and_an_optional_one_may():
    class Now(Protocol):
        declares: int

    class Later(Protocol):
        declares: int

        def answer(self) -> int: ...

    assert broken_promises(described("Sea", Now), described("Sea", Later))
    assert not broken_promises(described("SeaOptions", Now), described("SeaOptions", Later))
    assert not broken_promises([], described("NewKind", Later))


def test_the_kit_may_check_more_and_may_not_lose_a_knob():
    class More(SeaModelContract):
        pass

    lines = kit("SeaContract", SeaModelContract)
    assert "kit attribute SeaContract.reciprocity = 0.02" in lines
    assert "kit fixture SeaContract.wavenumber_cm1" in lines
    assert not [line for line in lines if "test_" in line]
    assert broken_promises(lines, [line for line in lines if "reciprocity" not in line])


def test_the_snapshot_is_not_written_over_a_broken_promise(tmp_path):
    path = tmp_path / "snapshot.txt"
    write(path)
    assert path.read_text(encoding="utf-8").splitlines() == api()
    kept = path.read_text(encoding="utf-8") + "field hcss_twin.providers.View 2. roll_deg: float = 0.0\n"
    path.write_text(kept, encoding="utf-8")
    with pytest.raises(SystemExit, match="gone or changed: field hcss_twin"):
        write(path)
    assert path.read_text(encoding="utf-8") == kept


def options():
    protocols = [getattr(providers, name) for name in providers.__all__ if name.endswith("Options")]
    return {name for each in protocols for name in (*each.__annotations__, *vars(each)) if not name.startswith("_")}


def asked_for(path):
    """Names that are looked up on an object which may lack them."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("getattr", "hasattr"):
            name = node.args[1]
            if isinstance(name, ast.Constant):
                yield name.value


def test_every_optional_member_the_engine_looks_for_is_documented_and_no_other():
    package = Path(hcss_twin.__file__).parent
    folders = [package / each for each in ("plan", "engine", "models/radiance")]
    files = [path for folder in folders for path in folder.rglob("*.py")]
    files += [
        package / "models" / "atmosphere" / "path_radiance.py",
        package / "providers" / "registry" / "discovery.py",
        package / "providers" / "registry" / "registry.py",
        package / "reports" / "cloud_columns.py",
        *(package / "providers" / "registry" / "guards").glob("*.py"),
    ]
    # Light transports and views of imagers are no providers, and not part of the frozen API.
    others = {"declares", "stage", "check", "over_views", "knows_surfaces", "knows_rays", "suns"}
    found = {name for path in files for name in asked_for(path)} - others
    assert found == options() == set(declared.OPTIONAL_MEMBERS)


def test_every_optional_member_says_its_shape_or_unit():
    for kind in ("CloudGenerator", "SeaModel", "Transmittance", "RadianceModel", "Sensor"):
        protocol = getattr(providers, f"{kind}Options")
        for name in protocol.__annotations__:
            assert f"{name} :" in protocol.__doc__
        for name, value in vars(protocol).items():
            if not name.startswith("_") and callable(value):
                assert value.__doc__
    assert {f"{kind.protocol}" for kind in Kind} <= set(providers.__all__)


def test_every_public_name_has_one_home():
    homes = [name for names in providers.HOMES.values() for name in names]
    assert sorted(homes) == sorted(providers.__all__)
    assert all(hasattr(providers, name) for name in homes)
