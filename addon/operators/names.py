# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of objects in an operator's one text."""

import json


def names_of(text: str) -> tuple[str, ...]:
    """Names with commas between, or a JSON list of names, which may have commas in them."""
    found = json.loads(text) if text.startswith("[") else text.split(",")
    return tuple(dict.fromkeys(name for each in found if (name := each.strip())))
