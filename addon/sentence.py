# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sentences with names and numbers in them, which can still be said in another language."""

from collections.abc import Callable


class Sentence(str):
    """A text with values put into a template: `Sentence("'{name}' has no faces.", name=obj.name)`.

    It is the English text. template, values: what it was made of; values may be sentences themselves.
    """

    def __new__(cls, template: str, **values):
        made = super().__new__(cls, template.format(**values))
        made.template, made.values = template, values
        return made

    def __deepcopy__(self, memo):
        return self  # which never changes


def said(text: str) -> Sentence:
    """A text as one that can be a value in another and is then translated with it."""
    return text if isinstance(text, Sentence) else Sentence(text)


def translated(text: str, translate: Callable[[str], str]) -> str:
    """A text in the language of `translate`, which is given templates and texts without values."""
    if not isinstance(text, Sentence):
        return translate(text)
    values = {k: translated(v, translate) if isinstance(v, Sentence) else v for k, v in text.values.items()}
    return translate(text.template).format(**values)
