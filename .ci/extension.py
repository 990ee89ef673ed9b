# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the extension's zips, one per platform, and validate them with Blender's own tool.

The manifest in the repository lists no wheels, so that the source tree can be enabled as an extension as it is, on any
Blender: one whose Python no listed wheel is for refuses the extension. They are added here, to a copy.
"""

import argparse
import email
import importlib.util
import re
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BLENDERS_OWN = {"bpy", "numpy"}

# The oldest systems that both Blender and the wheels run on. embreex has none for Linux and Windows on ARM.
PLATFORMS = {
    "linux-x64": "manylinux_2_28_x86_64",
    "macos-arm64": "macosx_13_0_arm64",
    "macos-x64": "macosx_13_0_x86_64",
    "windows-x64": "win_amd64",
}


def blender_ext(command: str, *arguments: str | Path) -> None:
    """Run Blender's extension tool; it ships in the bpy wheel and needs no Blender to run."""
    scripts = next(Path(importlib.util.find_spec("bpy").origin).parent.glob("*/scripts"))
    tool = scripts / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"
    tags = scripts / "modules" / "_bpy_internal" / "extensions" / "tags.py"
    subprocess.run([sys.executable, tool, command, "--valid-tags", tags, *arguments], check=True)


def requirement_name(requirement: str) -> str:
    return re.match(r"[\w.-]+", requirement)[0].lower()


def download_wheels(folder: Path, pythons: list[str]) -> list[Path]:
    """Fetch the wheels of everything in pyproject.toml that Blender lacks, for each platform and Python."""
    dependencies = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    wanted = [r for r in dependencies if requirement_name(r) not in BLENDERS_OWN]
    for python in pythons:
        for platform in PLATFORMS.values():
            pip = [sys.executable, "-m", "pip", "download", "-qq", "--no-deps", "--only-binary=:all:"]
            target = ["--implementation=cp", f"--python-version={python}", f"--platform={platform}"]
            subprocess.run([*pip, *target, f"--dest={folder}", *wanted], check=True)
    wheels = sorted(folder.glob("*.whl"))
    check_complete(wheels)
    return wheels


def check_complete(wheels: list[Path]) -> None:
    """Exit where a wheel needs a package that neither Blender nor the zip has."""
    there = BLENDERS_OWN | {wheel.name.split("-")[0].lower() for wheel in wheels}
    for wheel in wheels:
        with zipfile.ZipFile(wheel) as archive:
            metadata = next(name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
            needs = email.message_from_bytes(archive.read(metadata)).get_all("Requires-Dist", [])
        for need in needs:
            if "extra ==" not in need and requirement_name(need) not in there:
                sys.exit(f"{wheel.name} needs {need}: ship it too, or name it in BLENDERS_OWN")


def toml_list(name: str, items: list[str]) -> str:
    return f"{name} = [\n" + "".join(f'    "{item}",\n' for item in items) + "]\n"


def main() -> None:
    parser = argparse.ArgumentParser(description="Build and validate the extension.")
    parser.add_argument("--output", type=Path, default=ROOT / "dist", help="folder of the zips, emptied of older ones")
    parser.add_argument("--pythons", nargs="+", default=["3.11", "3.13"], help="Pythons to ship wheels for")
    parser.add_argument("--without-wheels", action="store_true", help="one zip of the source alone; needs no network")
    options = parser.parse_args()

    options.output.mkdir(parents=True, exist_ok=True)
    for old in options.output.glob("gi_bake-*.zip"):
        old.unlink()
    with tempfile.TemporaryDirectory() as temporary:
        if options.without_wheels:
            blender_ext("build", "--source-dir", ROOT, "--output-dir", options.output)
        else:
            # The source zip, unpacked, is the copy: what goes into it is said once, in the manifest.
            source, stage = Path(temporary, "source.zip"), Path(temporary, "stage")
            blender_ext("build", "--source-dir", ROOT, "--output-filepath", source)
            with zipfile.ZipFile(source) as archive:
                archive.extractall(stage)
            wheels = download_wheels(stage / "wheels", options.pythons)
            manifest = stage / "blender_manifest.toml"
            platforms = toml_list("platforms", list(PLATFORMS))
            wheels = toml_list("wheels", [f"./wheels/{wheel.name}" for wheel in wheels])
            manifest.write_text(platforms + wheels + manifest.read_text())
            blender_ext("build", "--split-platforms", "--source-dir", stage, "--output-dir", options.output)
    for built in sorted(options.output.glob("gi_bake-*.zip")):
        blender_ext("validate", built)


if __name__ == "__main__":
    main()
