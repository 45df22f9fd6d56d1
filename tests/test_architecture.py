"""The house: which room of vrlf may import which, read from the source with ``ast``.

A room is a module or folder directly under ``vrlf/``. Every import counts,
also those inside functions and those for type checking only: a name that a
room must not know is known either way.
"""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

# From the ground up; imports run to a lower row only. The ground floor has two
# rows because `resources` and `files` raise the errors. `vrlf` is the package
# itself, which hands on what `api` offers.
FLOORS = (
    ("errors", "units"),
    ("resources", "files"),
    ("model", "images"),
    ("optics", "gpu"),
    ("passes", "reference", "content"),
    ("solve", "scene"),
    ("renderer",),
    ("evaluation",),
    ("api",),
    ("vrlf",),
    ("studies",),
    ("app",),
    ("__main__",),
)
FLOOR_OF = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}

# A library on the left is known to the rooms on the right only.
KEEPERS = {
    "moderngl": {"gpu"},
    "glcontext": {"gpu"},
    "glfw": {"gpu", "app"},
    "imgui_bundle": {"app"},
    "OpenImageIO": {"images"},
    "pyrr": {"scene"},
    "pydantic": {"model"},
    "tomlkit": {"model"},
    "platformdirs": {"app"},
    "trimesh": {"scene"},
    "av": {"content"},
    "click": {"app"},
    "rich": {"app", "studies"},
    "matplotlib": {"studies"},
    "skimage": {"evaluation"},
    "flip_evaluator": {"evaluation"},
    "pycvvdp": {"evaluation"},
    "torch": {"evaluation"},
    "torchvision": {"evaluation"},
    # `studies`: sparse operators of patches, and a simplex.
    "scipy": {"evaluation", "reference", "studies"},
    "dask": {"studies"},
    "distributed": {"studies"},
    "pyarrow": {"studies"},
    "optuna": {"studies"},
    "ezdxf": {"studies"},
}
# A room on the left never sees the libraries on the right.
FORBIDDEN = {"model": {"numpy"}}

MOST_LINES = {"vrlf": 400, "shaders": 250}


class Import(NamedTuple):
    """Module ``importer`` (dotted) imports ``target`` (dotted) in line ``line``."""

    importer: str
    target: str
    line: int


def module_name(path: Path, package: Path) -> str:
    """Dotted name of the source file ``path`` of ``package``."""
    parts = path.relative_to(package.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def room_of(module: str) -> str:
    """The room that ``module`` lies in; ``vrlf`` for the package itself."""
    return module.split(".")[1] if "." in module else module


def sources(package: Path) -> dict[str, Path]:
    """Every module of ``package`` by its dotted name."""
    return {module_name(path, package): path for path in sorted(package.rglob("*.py"))}


def _base_of(node: ast.ImportFrom, importer: str, is_package: bool) -> str:
    """The absolute module that ``from ... import`` reads, relative dots resolved."""
    if not node.level:
        return node.module or ""
    parts = importer.split(".")
    kept = parts[: len(parts) - node.level + is_package]
    return ".".join(kept + ([node.module] if node.module else []))


def _late_import(node: ast.Call) -> str | None:
    """The module that ``import_module("...")`` names."""
    name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
    if name in {"import_module", "__import__"} and node.args:
        argument = node.args[0]
        if isinstance(argument, ast.Constant) and isinstance(argument.value, str):
            return argument.value
    return None


def imports_of(importer: str, path: Path, modules: set[str]) -> Iterator[Import]:
    """Every import that the file at ``path`` makes; ``modules`` tells modules from names."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"), str(path))):
        targets: list[str] = []
        if isinstance(node, ast.Import):
            targets = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = _base_of(node, importer, path.name == "__init__.py")
            # The version is a constant that every room may read from the package.
            names = [a.name for a in node.names if (base, a.name) != ("vrlf", "__version__")]
            targets = [f"{base}.{name}" if f"{base}.{name}" in modules else base for name in names]
        elif isinstance(node, ast.Call) and (late := _late_import(node)):
            targets = [late]
        for target in dict.fromkeys(targets):
            yield Import(importer, target, getattr(node, "lineno", 0))


def all_imports(package: Path) -> list[Import]:
    """Every import that any module of ``package`` makes."""
    found = sources(package)
    return [one for name, path in found.items() for one in imports_of(name, path, set(found))]


def floor_problems(imports: list[Import]) -> list[str]:
    """Imports between rooms that do not run down."""
    problems = []
    for importer, target, line in imports:
        if target.split(".")[0] != "vrlf":
            continue
        above, below = room_of(importer), room_of(target)
        strangers = [room for room in (above, below) if room not in FLOOR_OF]
        if strangers:
            problems.append(f"{importer}:{line} room {strangers[0]} stands on no floor")
        elif above != below and FLOOR_OF[below] >= FLOOR_OF[above]:
            way = "sideways to" if FLOOR_OF[below] == FLOOR_OF[above] else "up to"
            problems.append(f"{importer}:{line} imports {way} {target}")
    return problems


def library_problems(imports: list[Import]) -> list[str]:
    """Libraries that a room must not know."""
    problems = []
    for importer, target, line in imports:
        room, library = room_of(importer), target.split(".")[0]
        if room not in KEEPERS.get(library, {room}):
            problems.append(f"{importer}:{line} imports {library}, kept by {KEEPERS[library]}")
        if library in FORBIDDEN.get(room, ()):
            problems.append(f"{importer}:{line} imports {library}, forbidden in {room}")
    return problems


def circle_problems(imports: list[Import]) -> list[str]:
    """Modules that import each other in a circle, each circle once, as a path."""
    graph: dict[str, set[str]] = {}
    for importer, target, _ in imports:
        graph.setdefault(importer, set()).add(target)
    problems, done = [], set[str]()

    def walk(module: str, path: tuple[str, ...]) -> None:
        if module in path:
            circle = (*path[path.index(module) :], module)
            problems.append("circle: " + " -> ".join(circle))
        elif module not in done:
            for target in sorted(graph.get(module, ())):
                walk(target, (*path, module))
            done.add(module)

    for module in sorted(graph):
        walk(module, ())
    return problems


def too_long(root: Path) -> list[str]:
    """Files of ``root`` that hold more lines than their folder allows."""
    problems = []
    for folder, most in MOST_LINES.items():
        for path in sorted((root / folder).rglob("*")):
            if path.is_file() and path.suffix != ".pyc":
                lines = len(path.read_text(encoding="utf-8").splitlines())
                if lines > most:
                    name = path.relative_to(root)
                    problems.append(f"{name}: found {lines} lines, wanted at most {most}")
    return problems


def test_imports_run_down_the_floors(repo_root: Path) -> None:
    assert floor_problems(all_imports(repo_root / "vrlf")) == []


def test_every_module_stands_on_a_floor(repo_root: Path) -> None:
    rooms = {room_of(name) for name in sources(repo_root / "vrlf")}
    assert rooms - FLOOR_OF.keys() == set()


def test_no_imports_in_a_circle(repo_root: Path) -> None:
    assert circle_problems(all_imports(repo_root / "vrlf")) == []


def test_libraries_stay_in_their_rooms(repo_root: Path) -> None:
    assert library_problems(all_imports(repo_root / "vrlf")) == []


def test_no_file_is_too_long(repo_root: Path) -> None:
    assert too_long(repo_root) == []


def run_python(root: Path, code: str, *arguments: str) -> None:
    """Run ``code`` in a new interpreter at ``root``; its failure is the test's."""
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=root,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_importing_vrlf_leaves_the_gpu_alone(repo_root: Path) -> None:
    run_python(repo_root, "import sys, vrlf\nassert not {'moderngl', 'glfw'} & sys.modules.keys()")


ALL_DOORS_CLOSED = """
import importlib, sys
import glcontext, glfw, moderngl

def closed(*args, **kwargs):
    raise SystemExit("a module asked for a context while it was imported")

for library, names in (
    (moderngl, ("create_context", "create_standalone_context", "get_context")),
    (glcontext, ("default_backend", "get_backend_by_name")),
    (glfw, ("init", "create_window")),
):
    for name in names:
        assert hasattr(library, name), name
        setattr(library, name, closed)

for module in sys.argv[1:]:
    importlib.import_module(module)
"""


def test_importing_any_module_makes_no_context(repo_root: Path) -> None:
    modules = [name for name in sources(repo_root / "vrlf") if room_of(name) != "__main__"]
    run_python(repo_root, ALL_DOORS_CLOSED, *modules)


def test_a_context_made_while_importing_is_seen(tmp_path: Path) -> None:
    build(tmp_path, gpu__device="import moderngl\nmoderngl.create_context(standalone=True)")
    with pytest.raises(AssertionError, match="asked for a context"):
        run_python(tmp_path, ALL_DOORS_CLOSED, "vrlf.gpu.device")


# The checker itself, on fabricated houses.


def build(root: Path, **files: str) -> Path:
    """A package ``vrlf`` under ``root``; ``gpu__device="..."`` is ``vrlf/gpu/device.py``."""
    package = root / "vrlf"
    package.mkdir()
    (package / "__init__.py").write_text("")
    for name, text in files.items():
        path = package.joinpath(*name.split("__", 1)).with_suffix(".py")
        path.parent.mkdir(exist_ok=True)
        (path.parent / "__init__.py").touch()
        path.write_text(text)
    return package


@pytest.mark.parametrize(
    "files",
    [
        {"renderer": "from vrlf.model import rig", "model__rig": "import pydantic"},
        {"gpu__device": "import moderngl\nfrom . import ring", "gpu__ring": ""},
        {"images__read": "from ..errors import VrlfError\nfrom vrlf import __version__"},
        {"app__main": "def f():\n    from vrlf.studies import bench", "studies__bench": ""},
    ],
)
def test_a_sound_house_passes(tmp_path: Path, files: dict[str, str]) -> None:
    imports = all_imports(build(tmp_path, **files))
    assert floor_problems(imports) + library_problems(imports) + circle_problems(imports) == []


@pytest.mark.parametrize(
    ("files", "problem"),
    [
        ({"model__eye": "import vrlf.optics"}, "up to vrlf.optics"),
        ({"optics__ray": "\n\nfrom vrlf import renderer", "renderer": ""}, "optics.ray:3 imports"),
        ({"optics__ray": "from vrlf.gpu.device import Device"}, "sideways to vrlf.gpu.device"),
        ({"gpu__a": "from ..passes.blocks import X"}, "up to vrlf.passes.blocks"),
        ({"gpu__a": "def f():\n    from vrlf import load_rig"}, "gpu.a:2 imports up to vrlf"),
        ({"units": "import importlib\nimportlib.import_module('vrlf.app')"}, "up to vrlf.app"),
        ({"api": "import vrlf.studies.bench"}, "up to vrlf.studies.bench"),
        ({"cellar__wine": "import vrlf.errors"}, "room cellar stands on no floor"),
    ],
)
def test_a_bad_import_is_named(tmp_path: Path, files: dict[str, str], problem: str) -> None:
    found = floor_problems(all_imports(build(tmp_path, **files)))
    assert len(found) == 1
    assert problem in found[0]


@pytest.mark.parametrize(
    ("files", "problem"),
    [
        ({"renderer": "import moderngl"}, "vrlf.renderer:1 imports moderngl"),
        ({"content__video": "from OpenImageIO import ImageBuf"}, "imports OpenImageIO"),
        ({"model__rig": "import numpy.linalg as la"}, "imports numpy, forbidden in model"),
        ({"evaluation__report": "import rich.table"}, "imports rich"),
    ],
)
def test_a_misplaced_library_is_named(tmp_path: Path, files: dict[str, str], problem: str) -> None:
    found = library_problems(all_imports(build(tmp_path, **files)))
    assert len(found) == 1
    assert problem in found[0]


def test_a_circle_is_named_once(tmp_path: Path) -> None:
    package = build(
        tmp_path,
        gpu__a="from vrlf.gpu import b",
        gpu__b="from .c import C",
        gpu__c="def f():\n    import vrlf.gpu.a",
        gpu__d="from vrlf.gpu import a, c",
    )
    assert circle_problems(all_imports(package)) == [
        "circle: vrlf.gpu.a -> vrlf.gpu.b -> vrlf.gpu.c -> vrlf.gpu.a"
    ]


def test_a_long_file_is_named(tmp_path: Path) -> None:
    for folder, most in MOST_LINES.items():
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "fits.txt").write_text("x\n" * most)
        (tmp_path / folder / "long.txt").write_text("x\n" * (most + 1))
    assert [line.split(":")[0] for line in too_long(tmp_path)] == [
        "vrlf/long.txt",
        "shaders/long.txt",
    ]
