# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders are plain GLSL, which Blender can turn into Metal's and Vulkan's languages. These are not at hand; their
rules are."""

import re
from pathlib import Path

import pytest
from gi_bake.gi_core import kernels

FILES = sorted(Path(kernels.__file__).parent.glob("*.glsl"))

# Words of Metal's or C++, of which a shader may make no names.
TAKEN = """
alignas and auto atomic bitand bitor case catch char class compl constant constexpr decltype delete depth2d
device dynamic_cast enum explicit export extern fragment friend goto half int8_t long mutable namespace new
noexcept not nullptr operator or private protected public register sampler short signed sizeof static
static_cast stage_in template texture this thread threadgroup throw try typedef typeid typename union unsigned
using vertex virtual volatile wchar_t xor
"""

DEFINED = re.compile(r"^(?:void|bool|int|uint|float|[biu]?vec[234]|mat[234]) (\w+)\(([^)]*)\)", re.M)


def code(text: str) -> str:
    return re.sub(r"//[^\n]*", "", text)


def faults(text: str) -> list[str]:
    """What a translator would not take, or not as it is meant."""
    text = code(text)
    found = [f"'{word}'" for word in re.findall(r"\b(?:double|dvec[234]|dmat[234]|long|half)\b", text)]
    found += [f"declared ahead: {name}" for name, _ in re.findall(DEFINED.pattern + r"\s*;", text, re.M)]
    found += [
        f"a literal to be written out: {n}"
        for n in re.findall(r"(?<![\w.])(?:\d+\.(?!\d)|\.\d+|\d+\.?\d*[fF]\b)", text)
    ]
    found += [f"a whole number for a float: {n}" for n in re.findall(r"\bfloat \w+ = -?\d+\s*[;,]", text)]
    found += [
        f"a whole number in a vector: {n}" for n in re.findall(r"(?<![\w])vec[234]\((?:[^()]*,)?\s*-?\d+\s*[,)]", text)
    ]
    found += [f"an array made in one go: {n}" for n in re.findall(r"\b\w+\s*\[\d*\]\s*\(", text)]
    names = set(re.findall(r"\b(?:bool|int|uint|float|[biu]?vec[234]|mat[234]) (\w+)", text))
    found += [f"a word of Metal's: {name}" for name in sorted(names & set(TAKEN.split()))]
    for match in DEFINED.finditer(text):
        # Nor does any function call itself.
        body = re.match(r"[^{]*\{.*?^\}", text[match.start() :], re.S | re.M)
        before = text[: match.start()] + (body[0][len(match[0]) :] if body else "")
        if re.search(rf"\b{match[1]}\(", before):
            found.append(f"used before it is defined: {match[1]}")
    return found


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_shaders_are_plain(path):
    assert faults(path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("text", [
    "double x;", "float f(int i);", "float x = 1.;", "float x = .5;", "float x = 1.0f;", "float x = 1;",
    "vec3 v = vec3(0, 1.0, 2.0);", "vec3 v = vec3(0);", "float a[2] = float[](1.0, 2.0);", "int device = 1;",
    "float g()\n{\n  return f();\n}\nfloat f()\n{\n  return 1.0;\n}\n", "int f(int i)\n{\n  return f(i - 1);\n}\n",
])  # fmt: skip
def test_faults_are_found(text):
    assert faults(text)


def test_all_shaders_are_looked_at():
    assert len(FILES) > 40
