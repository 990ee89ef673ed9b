# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The console script `gi-bake`, for the bpy wheel."""

from .standard_output import quiet


def main() -> int:
    """Runs the command line on sys.argv; the exit code."""
    # bpy speaks already when it is imported.
    with quiet():
        from . import cli
    return cli.main()
