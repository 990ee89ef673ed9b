# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Open Image Denoise itself, the library that Blender has loaded for its compositor and Cycles.

Called so it touches nothing of Blender's, on whatever thread, and lets Python go on meanwhile. Its interface in C is
that of version 2: https://www.openimagedenoise.org/documentation.html
"""

import contextlib
import ctypes
import functools
import os
from collections.abc import Iterator
from ctypes import c_bool, c_char_p, c_int, c_size_t, c_void_p

import numpy as np

# Of Linux, Windows and macOS; the first is for where Blender's program itself is linked to it.
_NAMES = (None, "libOpenImageDenoise.so.2", "OpenImageDenoise.dll", "libOpenImageDenoise.2.dylib")

# Name -> result and arguments.
_FUNCTIONS = {
    "oidnNewDevice": (c_void_p, c_int),
    "oidnSetDeviceBool": (None, c_void_p, c_char_p, c_bool),
    "oidnCommitDevice": (None, c_void_p),
    "oidnGetDeviceError": (c_int, c_void_p, ctypes.POINTER(c_char_p)),
    "oidnReleaseDevice": (None, c_void_p),
    "oidnNewFilter": (c_void_p, c_void_p, c_char_p),
    "oidnSetSharedFilterImage": (None, c_void_p, c_char_p, c_void_p, c_int, *[c_size_t] * 5),
    "oidnSetFilterBool": (None, c_void_p, c_char_p, c_bool),
    "oidnCommitFilter": (None, c_void_p),
    "oidnExecuteFilter": (None, c_void_p),
    "oidnReleaseFilter": (None, c_void_p),
}

_CPU, _FLOAT3 = 1, 3


@functools.cache
def library() -> ctypes.CDLL | None:
    """The library, where this Blender has it, it can be reached and the processor is one for it."""
    for name in _NAMES:
        try:
            found = ctypes.CDLL(name, mode=getattr(os, "RTLD_NOLOAD", 0))
            for function, (result, *arguments) in _FUNCTIONS.items():
                called = getattr(found, function)
                called.restype, called.argtypes = result, arguments
            with _device(found):
                return found
        except (OSError, AttributeError, TypeError, RuntimeError):
            continue
    return None


def denoised(image: np.ndarray, guides: dict[str, np.ndarray]) -> np.ndarray:
    """An image without its noise: (h, w, 3) float32, of any range. guides: "albedo" and "normal", without noise.

    The same as Blender's Denoise node makes. Raises RuntimeError with what the library says where it fails.
    """
    oidn, (height, width) = library(), image.shape[:2]
    clean = np.empty((height, width, 3), np.float32)
    images = {name: np.ascontiguousarray(pixels, np.float32) for name, pixels in {"color": image, **guides}.items()}
    with _device(oidn) as device:
        made = oidn.oidnNewFilter(device, b"RT")
        try:
            for name, pixels in (*images.items(), ("output", clean)):
                at = pixels.ctypes.data
                oidn.oidnSetSharedFilterImage(made, name.encode(), at, _FLOAT3, width, height, 0, 0, 0)
            for name in (b"hdr", b"cleanAux"):
                oidn.oidnSetFilterBool(made, name, True)
            oidn.oidnCommitFilter(made)
            oidn.oidnExecuteFilter(made)
            _check(oidn, device)
        finally:
            oidn.oidnReleaseFilter(made)
    return clean


@contextlib.contextmanager
def _device(oidn: ctypes.CDLL) -> Iterator[int]:
    device = oidn.oidnNewDevice(_CPU)
    try:
        # Or else it would tie threads to cores, which Blender's own share.
        oidn.oidnSetDeviceBool(device, b"setAffinity", False)
        oidn.oidnCommitDevice(device)
        _check(oidn, device)
        yield device
    finally:
        oidn.oidnReleaseDevice(device)


def _check(oidn: ctypes.CDLL, device: int) -> None:
    said = c_char_p()
    if oidn.oidnGetDeviceError(device, ctypes.byref(said)):
        raise RuntimeError(f"Open Image Denoise failed: {(said.value or b'').decode(errors='replace')}")
