# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Standard output belongs to the answer: Blender's own chatter is kept off it."""

import contextlib
import ctypes
import os
import sys
from pathlib import Path


@contextlib.contextmanager
def quiet():
    """Sends what is written to standard output, also below Python, to nowhere."""
    sys.stdout.flush()
    kept = os.dup(1)
    try:
        with Path(os.devnull).open("wb") as nowhere:
            os.dup2(nowhere.fileno(), 1)
        yield
    finally:
        sys.stdout.flush()
        # Blender's lines wait in the C library's buffer and would come out later.
        ctypes.CDLL("ucrtbase" if os.name == "nt" else None).fflush(None)
        os.dup2(kept, 1)
        os.close(kept)
