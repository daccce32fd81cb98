"""What is shipped is all that is needed, and says what it is."""

from __future__ import annotations

import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from itertools import chain

import pytest

from .pages import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Return the folder of a wheel and a source distribution built from here."""
    pytest.importorskip("hatchling", reason="needs hatchling: install ppinfer[dev]")
    folder = tmp_path_factory.mktemp("dist")
    ran = subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-d", str(folder)],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    return folder


def files_below(*packages):
    """Return the files of packages that have to be shipped, relative to the folder that holds the package."""
    return {
        file.relative_to((ROOT / package).parent).as_posix()
        for package in packages
        for file in (ROOT / package).rglob("*")
        if file.is_file() and "__pycache__" not in file.parts
    }


def test_the_wheel_holds_both_packages_with_their_types_schemas_and_templates(built):
    (wheel,) = built.glob("*.whl")
    names = set(zipfile.ZipFile(wheel).namelist())
    assert files_below("ppinfer", "sim/ppsim") <= names
    assert {"ppinfer/py.typed", "ppsim/py.typed", "ppinfer/cli/schemas/score.schema.json"} <= names
    inside = {name.partition("/")[0] for name in names}
    assert {name for name in inside if "." not in name} == {"ppinfer", "ppsim"}


def test_the_wheel_holds_the_licence_the_notebooks_and_the_small_logs(built):
    (wheel,) = built.glob("*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert any(name.endswith("dist-info/licenses/LICENSE") for name in names)
    shared = {name.partition("/data/share/ppinfer/")[2] for name in names if "/data/share/ppinfer/" in name}
    assert files_below("notebooks", "data") <= shared


def test_the_source_distribution_holds_what_builds_and_tests_it(built):
    (source,) = built.glob("*.tar.gz")
    with tarfile.open(source) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    needed = {"pyproject.toml", "README.md", "LICENSE", "CITATION.cff", "CHANGELOG.md", "constraints.txt"}
    assert needed <= names
    assert {"tests/conftest.py", "docs/commands.md", "ppinfer/__init__.py", "sim/ppsim/__init__.py"} <= names


def test_constraints_are_plain_versions_of_everything_that_is_required():
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    assert all(re.fullmatch(r"[A-Za-z0-9._-]+==[A-Za-z0-9.!+]+", line) for line in lines)
    pinned = {normalised(line.partition("==")[0]) for line in lines}
    asked = [*PROJECT["dependencies"], *chain(*PROJECT["optional-dependencies"].values())]
    assert {normalised(re.match(r"[A-Za-z0-9._-]+", line)[0]) for line in asked} <= pinned


def normalised(name):
    """Return a distribution's name as indexes compare it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def test_the_version_is_the_same_wherever_it_is_written():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    version = PROJECT["version"]
    assert re.search(rf"^version: {re.escape(version)}$", citation, re.MULTILINE)
    assert f"## [{version}]" in changes or "## [Unreleased]" in changes
