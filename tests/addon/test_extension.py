# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension as Blender takes it: enabled, disabled, built and validated."""

import json
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The names in the zip of the source. To build it, Blender's own tool has to accept the manifest and the zip."""
    folder = tmp_path_factory.mktemp("dist")
    build = [sys.executable, ROOT / ".ci" / "extension.py", "--without-wheels", "--output", folder]
    done = subprocess.run(build, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    with zipfile.ZipFile(*folder.glob("*.zip")) as archive:
        return set(archive.namelist())


def test_zip_holds_the_code_and_nothing_else(built):
    code = {file for part in ("addon", "gi_core") for file in (ROOT / part).rglob("*") if file.is_file()}
    code = {file.relative_to(ROOT).as_posix() for file in code if file.parent.name != "__pycache__"}
    assert built == code | {"__init__.py", "blender_manifest.toml", "LICENSE"}


def test_manifest_and_package_agree():
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text())
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    assert manifest["version"] == project["project"]["version"]
    assert manifest["license"] == ["SPDX:" + project["project"]["license"]]

    folders = {file.parent for part in ("addon", "gi_core") for file in (ROOT / part).rglob("*.py")}
    packages = {".".join(("gi_bake", *folder.relative_to(ROOT).parts)) for folder in folders}
    assert set(project["tool"]["setuptools"]["packages"]) == packages | {"gi_bake"}


def test_extension_is_enabled_with_relative_imports_only(extension):
    assert extension.__addon_enabled__
    assert extension.__name__ + ".addon" in sys.modules


def test_enabling_ten_times_leaves_nothing_behind(tmp_path):
    (tmp_path / "gi_bake").symlink_to(ROOT, target_is_directory=True)
    report = tmp_path / "report.json"
    script = Path(__file__).with_name("enable_ten_times.py")
    done = subprocess.run([sys.executable, script, tmp_path, report], capture_output=True, text=True, timeout=120)
    assert report.exists(), done.stdout + done.stderr
    found = json.loads(report.read_text())
    assert found["added"], "the extension registers nothing"
    assert found["left"] == []
