# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is wrong, as findings: errors made into them, and told where Blender shows and logs what operators say."""

import logging
import traceback

from bpy.app.translations import pgettext_rpt as rpt_
from bpy.types import Operator

from ...gi_core.settings import SettingError
from .. import preflight
from ..bake import Refused
from ..job import NotThere
from ..sentence import Sentence, translated

log = logging.getLogger(__name__)


def report(operator: Operator, findings) -> None:
    """Errors and warnings where Blender shows and logs them: all in one, since a report in a script is an exception."""
    for severity in ("WARNING", "ERROR"):
        said = [f for f in findings if f.severity == severity]
        if said:
            text = "\n".join(
                f"{f.code}: {translated(f.message, rpt_)} {translated(f.remedy, rpt_)}" for f in said[:5]
            )
            more = rpt_("\n… and {:d} more").format(len(said) - 5) if len(said) > 5 else ""
            operator.report({severity}, text + more)


def failure(error: Exception) -> list[preflight.Finding]:
    """An error as findings: of the preflight, of a setting, or one that nobody foresaw."""
    if isinstance(error, Refused):
        return error.findings
    if isinstance(error, (NotThere, SettingError)):
        said = Sentence("The settings do not go together: {why}.", why=error)
        return [preflight.Finding("SETTING", "ERROR", "", said, "Change them, or choose a preset.")]
    if isinstance(error, MemoryError):
        remedy = "Lower the resolution or the setting Memory."
        return [preflight.Finding("OUT_OF_MEMORY", "ERROR", "", "The machine has no memory left.", remedy)]
    if isinstance(error, OSError):
        remedy = "Choose another output folder."
        said = Sentence("A file was not written: {why}.", why=error)
        return [preflight.Finding("NOT_WRITTEN", "ERROR", "", said, remedy)]
    log.error("%s", "".join(traceback.format_exception(error)))
    remedy = "The system console says where; nothing was changed."
    return [preflight.Finding("FAILED", "ERROR", "", Sentence("It failed: {why}.", why=error), remedy)]
