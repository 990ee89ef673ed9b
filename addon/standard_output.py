# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Standard output belongs to the answer, and standard error to what a person should know: Blender's own chatter is
kept off them."""

import contextlib
import ctypes
import os
import sys
from pathlib import Path


@contextlib.contextmanager
def quiet(number: int = 1):
    """Sends what is written to standard output, 1, or standard error, 2, also below Python, to nowhere."""
    stream = {1: sys.stdout, 2: sys.stderr}[number]
    stream.flush()
    kept = os.dup(number)
    try:
        with Path(os.devnull).open("wb") as nowhere:
            os.dup2(nowhere.fileno(), number)
        yield
    finally:
        stream.flush()
        # Blender's lines wait in the C library's buffer and would come out later.
        ctypes.CDLL("ucrtbase" if os.name == "nt" else None).fflush(None)
        os.dup2(kept, number)
        os.close(kept)
