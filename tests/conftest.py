# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests share: Blender kept apart from the user's own, the extension enabled in it, the sample files."""

import importlib.metadata
import importlib.util
import os
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parent.parent
BPY = importlib.util.find_spec("bpy")

if BPY is None:
    collect_ignore = ["addon"]
else:
    # openvdb and OpenImageIO come with Blender, in a folder that the bpy wheel leaves off the path.
    sys.path.extend(str(p) for p in Path(BPY.origin).parent.glob("*/python/lib/python3.*/site-packages"))


def pytest_configure(config):
    # Blender keeps a cache of extensions among the user's settings; bpy reads the variable when it is imported.
    config.blender_user_resources = os.environ["BLENDER_USER_RESOURCES"] = tempfile.mkdtemp(prefix="gi_bake_tests_")
    os.environ["GI_BAKE_CACHE"] = str(Path(config.blender_user_resources) / "gi_bake")


def pytest_sessionstart(session):
    session.config.session = session


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config):
    shutil.rmtree(config.blender_user_resources, ignore_errors=True)
    bpy = sys.modules.get("bpy")
    if bpy is not None and bpy.app.version < (5, 0):  # Blender 4.5 may hang while Python takes it down
        config.get_terminal_writer().flush()
        os._exit(config.session.exitstatus)


def pytest_report_header():
    return f"bpy: {importlib.metadata.version('bpy')}" if BPY else "bpy: not installed, tests/addon is left out"


@pytest.fixture(scope="session")
def extension(tmp_path_factory):
    """The repository enabled as the extension `bl_ext.t.gi_bake`; the module.

    `bpy.ops.wm.read_homefile(use_empty=True)` leaves it enabled, `read_factory_settings` does not.
    """
    import bpy

    import addon_utils

    def fail(error):
        raise error

    folder = tmp_path_factory.mktemp("repository")
    (folder / "gi_bake").symlink_to(ROOT, target_is_directory=True)
    repositories = bpy.context.preferences.extensions.repos
    repository = repositories.new(name="t", module="t", custom_directory=str(folder))
    yield addon_utils.enable("bl_ext.t.gi_bake", default_set=True, persistent=True, handle_error=fail)
    addon_utils.disable("bl_ext.t.gi_bake", default_set=True, handle_error=fail)
    repositories.remove(repository)


@pytest.fixture(scope="session")
def gpu():
    """A GpuDevice, in software without a card. Skips without a driver, fails where GI_BAKE_GPU is `required`."""
    from gi_bake.addon import gpu_context

    device, why_not = gpu_context.device("gpu")
    if why_not:
        (pytest.fail if os.environ.get("GI_BAKE_GPU") == "required" else pytest.skip)(why_not)
    return device


@pytest.fixture
def same(gpu):
    """Holds a kernel on the graphics card against its definition: `same(kernel, *arguments, tolerance=1e-4)`.

    Numbers may differ by the tolerance as a share of the greatest; what else a kernel gives must be the same.
    """

    def check(kernel, *arguments, tolerance=1e-4, **settings):
        expected, found = kernel(*arguments, **settings), gpu.run(kernel, *arguments, **settings)
        if not isinstance(expected, tuple):
            expected, found = (expected,), (found,)
        assert len(found) == len(expected)
        for e, f in zip(expected, map(gpu.numpy, found)):
            assert f.shape == e.shape and f.dtype.kind == e.dtype.kind
            if e.dtype.kind == "f":
                np.testing.assert_allclose(f, e, rtol=tolerance, atol=tolerance * np.abs(e).max(initial=0))
            else:
                np.testing.assert_array_equal(f, e)

    return check


@pytest.fixture(scope="session")
def sample():
    """The path of a file in sample_blends/ by its name: `sample("cornell")`."""

    def path(name: str) -> Path:
        file = ROOT / "sample_blends" / f"{name}.blend"
        assert file.is_file(), f"{file} is missing: make samples"
        return file

    return path
