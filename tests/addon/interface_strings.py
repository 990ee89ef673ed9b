# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that the extension's interface says, found in its registered classes and in its source."""

import ast
import sys
from pathlib import Path

import bpy

ADDON = Path(__file__).resolve().parents[2] / "addon"
# Calls whose text a person reads.
_SAYING = {"iface_", "rpt_", "poll_message_set", "pgettext_iface", "Sentence", "note"}
# Calls whose later arguments name a quantity, to be said where that is not exact.
_QUANTITIES = {"read_color", "read_number", "read_factor", "product", "total", "quotient", "summed"}
# What findings are made of, by calls whose later arguments are sentences and by names of variables.
_FINDING, _SENTENCES = {"_error", "_warning", "finding", "Finding"}, {"message", "remedy", "why"}
_SAID_AS = {"text", "heading"}


def classes(package: str) -> list[type]:
    """What the extension has registered: classes of modules below `package`."""
    found, stack = [], list(bpy.types.bpy_struct.__subclasses__())
    while stack:
        cls = stack.pop()
        stack += cls.__subclasses__()
        if cls.__module__.startswith(package) and getattr(cls, "is_registered", False):
            found.append(cls)
    return found


def of_classes(package: str) -> set[str]:
    """Labels and descriptions of classes, properties and enum items."""
    said = set()
    for cls in classes(package):
        said.add(getattr(cls, "bl_label", ""))
        said |= {text for prop in properties(cls) for text in _of_property(prop)}
        if issubclass(cls, bpy.types.Operator):
            said.add(rna(cls).description)
    return said - {""}


def rna(cls: type) -> bpy.types.Struct:
    """A class as Blender sees it; an operator's own says nothing of its properties."""
    if issubclass(cls, bpy.types.Operator):
        group, name = cls.bl_idname.split(".")
        return getattr(getattr(bpy.ops, group), name).get_rna_type()
    return cls.bl_rna


def properties(cls: type) -> list[bpy.types.Property]:
    """The properties of a class that are its own and that people see."""
    theirs = {key for base in cls.__mro__ for key in getattr(base, "__annotations__", {})}
    inherited = {"rna_type", "name"} if "Preset" in cls.__name__ or "preset" in cls.__name__ else {"rna_type"}
    return [p for key, p in rna(cls).properties.items() if key in theirs - inherited and not p.is_hidden]


def _of_property(prop: bpy.types.Property) -> set[str]:
    items = prop.enum_items if prop.type == "ENUM" else ()
    return {prop.name, prop.description} | {text for item in items for text in (item.name, item.description)}


def of_source() -> set[str]:
    """Literal texts handed to the interface and to Blender's translation."""
    said = set()
    for file in ADDON.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Dict) and file.parent.name == "ui":
                said |= _labels(node)
            if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") in _SENTENCES:
                said |= _texts([node.value])
            if isinstance(node, ast.Return) and isinstance(node.value, ast.Tuple):
                # Why something cannot be, and the remedy.
                said |= {text for text in _texts(node.value.elts) if " " in text}
            if not isinstance(node, ast.Call):
                continue
            name = getattr(node.func, "id", getattr(node.func, "attr", ""))
            literal = [k.value for k in node.keywords if k.arg in _SAID_AS] if name in {"label", "operator"} else []
            if name in _SAYING:
                literal += node.args
            if name == "report":
                literal += node.args[1:]
            if name in _QUANTITIES and file.parent.name == "read":
                literal += node.args[1:]
            if name in _FINDING:
                literal += node.args[2:]
            said |= _texts(literal)
    said |= set(_module("addon.read.expression")._NOT_THERE.values())
    main, remedies = (_module(f"addon.{name}") for name in ("ui.main", "operators.remedies"))
    return (said | set(main.STAGES.values()) | {text for _, text in remedies.REMEDIES.values()}) - {""}


def _texts(nodes) -> set[str]:
    """Literal texts, those of either outcome of a condition too."""
    nodes = [e for node in nodes for e in ([node.body, node.orelse] if isinstance(node, ast.IfExp) else [node])]
    return {e.value for e in nodes if isinstance(e, ast.Constant) and isinstance(e.value, str)}


def _module(name: str):
    return sys.modules[next(m for m in sys.modules if m.endswith(f".gi_bake.{name}"))]


def _labels(node: ast.Dict) -> set[str]:
    """Keys that are shown before values: "Texels", "Memory"."""
    words = [e.value for e in (*node.keys, *node.values) if isinstance(e, ast.Constant) and isinstance(e.value, str)]
    return {word for word in words if word[:1].isupper() and not word.isupper() and "_" not in word}
