# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether an operator can start now, said as `poll` says it."""

from ..session import session


def busy(cls) -> bool:
    """Whether a bake or a comparison is on its way, said as `poll` says it."""
    if session.run:
        cls.poll_message_set("GI Bake is at work: wait, or cancel it")
    return session.run is not None
