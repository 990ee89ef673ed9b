# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A process that answers cases, a line of JSON for each; one that fails or takes too long costs no more than itself."""

import json
import subprocess
import tempfile
import threading


class Worker:
    """Runs a command when it is first asked, and anew after a case at which it ended or was ended.

    command: reads lines [case, arguments], and writes for each a line with an object. limit: seconds that a case may
        take. Ends its process where the `with` ends.
    """

    def __init__(self, command: list[str], limit: float):
        self.command, self.limit, self.process = command, limit, None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._end()

    def ask(self, case: str, arguments: dict) -> dict:
        """The command's answer; {"failed": why} where there is none."""
        if self.process is None:
            self.words = tempfile.TemporaryFile("w+", errors="replace")
            pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": self.words}
            self.process = subprocess.Popen(self.command, text=True, **pipes)
        process, late = self.process, threading.Event()
        timer = threading.Timer(self.limit, lambda: (late.set(), process.kill()))
        timer.start()
        try:
            process.stdin.write(json.dumps([case, arguments]) + "\n")
            process.stdin.flush()
            # Blender may have a word of its own to say.
            line = next((line for line in process.stdout if line.startswith("{")), "")
        except BrokenPipeError:
            line = ""
        finally:
            timer.cancel()
        answer = json.loads(line) if line.endswith("\n") else None
        if answer is None or "failed" in answer:
            # After an error nobody knows what is left in the process.
            answer = answer or {"failed": f"took longer than {self.limit:g} s" if late.is_set() else self._last_words()}
            self._end()
        return answer

    def _last_words(self):
        status = self.process.wait()
        self.words.seek(0)
        told = [line for line in self.words.read().splitlines() if line.strip()]
        return f"ended with {status}: {told[-1].strip() if told else 'no word'}"

    def _end(self):
        if self.process is None:
            return
        self.process.kill()
        self.process.communicate()
        self.words.close()
        self.process = None
