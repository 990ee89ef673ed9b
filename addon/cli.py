# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: one parser for two ways in.

    blender SCENE.blend --command gi_bake SUBCOMMAND ...     the installed extension
    gi-bake SUBCOMMAND SCENE.blend ...                       with the bpy wheel

Exit codes: 0 done, 2 wrong usage, 3 refused by the preflight, 4 failed, 130 cancelled.
"""

import argparse
import json
import os
import re
import signal
import sys
import time
import traceback
from dataclasses import asdict, fields
from pathlib import Path

import bpy

from ..gi_core.geometry import Geometry
from ..gi_core.lpv.grid import memory
from ..gi_core.settings import SettingError, updated
from ..gi_core.techniques import METHODS
from . import layout, preflight
from .animation import bake_frames
from .bake import Refused, bake, missing_uvs, receiving
from .compare import compare, dark_box
from .compare.report import finite
from .job import Job, NotThere
from .result import Result
from .standard_output import quiet
from .write import lightmap_uvs
from .write.results import export, store

DONE, USAGE, REFUSED, FAILED, CANCELLED = 0, 2, 3, 4, 130


class UsageError(Exception):
    """What was asked for cannot be done as it was written."""


def parser(prog: str, takes_scene: bool) -> argparse.ArgumentParser:
    """takes_scene: the .blend is an argument; else it is the file that Blender has open."""
    top = argparse.ArgumentParser(prog=prog, description="Bake global illumination and measure it against Cycles.")
    commands = top.add_subparsers(dest="command", required=True, metavar="bake|compare|check")
    for name, text in (
        ("bake", "bake light and write it to files, and with --save into the .blend"),
        ("compare", "bake, render the same with Cycles, and report how far apart they are"),
        ("check", "say what would keep the scene from baking, without baking it"),
    ):
        sub = commands.add_parser(
            name, help=text, description=text[0].upper() + text[1:] + ".", epilog=_settings_help(),
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )  # fmt: skip
        if takes_scene:
            sub.add_argument("scene", metavar="SCENE.blend", type=Path)
        several = name == "compare"
        sub.add_argument(
            "--method",
            default="rsm",
            metavar="rsm|lpv|ssgi",
            help="technique (rsm)" + ("; several with commas between, side by side" if several else ""),
        )
        sub.add_argument(
            "--target",
            default="image",
            metavar="image|lightmap|vertices|volume",
            help="what the light is baked for (image)",
        )
        sub.add_argument("--output", metavar="DIR", help="folder for files (gi_bake beside the .blend)")
        sub.add_argument(
            "--resolution", type=int, metavar="N", help="side of lightmaps, or longer side of the image [px]"
        )
        sub.add_argument("--objects", default="", metavar="NAME,…", help="objects to bake (all that render)")
        sub.add_argument("--frame", type=int, metavar="N", help="frame to bake (the current one)")
        sub.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="any setting; see below")
        sub.add_argument("--seed", metavar="N", help="start of the random sequence")
        sub.add_argument("--device", metavar="auto|cpu|gpu", help="what computes")
        sub.add_argument(
            "--save", nargs="?", const="", metavar="FILE", help="save a .blend with the results (in the output folder)"
        )
        sub.add_argument(
            "--json", action="store_true", help="print one JSON object on standard output and nothing else"
        )
        if name == "bake":
            sub.add_argument("--frames", metavar="A-B", help="frames to bake to image.NNNN.exr, one after the other")
        if name == "compare":
            sub.add_argument(
                "--reference-samples", type=_positive, default=1024, metavar="N", help="Cycles' samples (1024)"
            )
            sub.add_argument(
                "--dark", default="", metavar="OBJECT|BOX",
                help="a region without light, an object's box or 'x y z x y z': what light is there is a leak",
            )  # fmt: skip
            sub.add_argument(
                "--curves", action="store_true", help="also error over time, at several budgets, ours and Cycles'"
            )
    return top


def _positive(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{value} is less than 1")
    return value


def main(argv: list[str] | None = None) -> int:
    """The console script: opens the .blend itself."""
    arguments = parser("gi-bake", takes_scene=True).parse_args(argv)
    return _run(arguments, arguments.scene)


def command(argv: list[str]) -> int:
    """Blender's --command: works on the file that is open."""
    try:
        arguments = parser("blender SCENE.blend --command gi_bake", takes_scene=False).parse_args(argv)
    except SystemExit as stop:
        return int(stop.code or 0)
    return _run(arguments, None)


def _run(arguments: argparse.Namespace, path: Path | None) -> int:
    """Runs a subcommand; errors become a line on standard error and an exit code."""
    # Blender answers an interrupt in its own way, or not at all; ours unwinds the bake.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with quiet():
            code, answer = DONE, _COMMANDS[arguments.command](arguments, path)
    except (UsageError, NotThere, SettingError) as error:
        code, answer = USAGE, {"error": str(error)}
    except Refused as refused:
        code, answer = REFUSED, {"error": "refused", "findings": [asdict(f) for f in refused.findings]}
    except KeyboardInterrupt:
        code, answer = CANCELLED, {"error": "cancelled; nothing was written"}
    except Exception as error:
        traceback.print_exc()
        code, answer = FAILED, {"error": f"failed: {error}"}
    finally:
        # None: whoever handled it before was not Python, and cannot be put back from here.
        if before is not None:
            signal.signal(signal.SIGINT, before)

    if code != DONE:
        sys.stderr.write(f"gi-bake: {answer['error']}\n" + "".join(_finding(f) for f in answer.get("findings", ())))
    text = json.dumps(finite(answer), indent=1, allow_nan=False) + "\n" if arguments.json else ""
    text = _table(answer) if code == DONE and not arguments.json else text
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except BrokenPipeError:
        # Whoever read has had enough; the work is done all the same. Python would complain once more when it ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return code


def _check(arguments: argparse.Namespace, path: Path | None) -> dict:
    scene, view_layer = _open(arguments, path)
    job = _job(arguments)
    with lightmap_uvs.lent(missing_uvs(scene, view_layer, job)):
        findings, core = preflight.inspected(
            scene, view_layer, None,
            target=job.target, objects=job.objects, uv=job.uv, output=_output(arguments),
            denoise=job.settings.denoise, glossy=job.settings.glossy,
        )  # fmt: skip
    if any(f.severity == "ERROR" for f in findings):
        raise Refused(findings)
    pages = []
    if job.target == "lightmap":
        names = receiving(core, job)
        pages = layout.pages(Geometry(core), scene, names, job.uv, job.resolution, job.settings)
    volume = memory(job.settings) if job.method == "lpv" else None
    lightmaps = [
        {
            "name": p.name, "width": p.width, "height": p.height, "padding": job.settings.room,
            "objects": {q.name: q.side for q in p.places},
        }
        for p in pages
    ]  # fmt: skip
    return {"findings": [asdict(f) for f in findings], "volume_bytes": volume, "lightmaps": lightmaps}


def _bake(arguments: argparse.Namespace, path: Path | None) -> dict:
    if arguments.frames is not None:
        return _animation(arguments, path)
    job = _job(arguments)
    scene, view_layer = _open(arguments, path)
    return _baked(arguments, job, scene, view_layer, _output(arguments))[0]


def _animation(arguments: argparse.Namespace, path: Path | None) -> dict:
    job, frames = _job(arguments), _frames(arguments.frames)
    if job.target != "image" or arguments.save is not None or arguments.frame is not None:
        raise UsageError("--frames bakes camera images to files: another target, --save or --frame do not go with it")
    scene, view_layer = _open(arguments, path)
    begin = time.perf_counter()
    paths = _followed(bake_frames(scene, view_layer, job, frames, _output(arguments)))
    return {
        "method": job.method, "target": job.target, "device": "cpu", "stages": {},
        "seconds": round(time.perf_counter() - begin, 4), "outputs": [str(p) for p in paths], "metrics": None,
        "approximated": [], "warnings": [],
    }  # fmt: skip


def _frames(text: str) -> range:
    """ "A-B" as frames; either may be negative."""
    match = re.fullmatch(r"(-?\d{1,7})-(-?\d{1,7})", text)
    first, last = (int(n) for n in match.groups()) if match else (1, 0)
    if first > last or max(-first, last) > 1048574:
        raise UsageError(f"--frames takes the first and the last frame as A-B, not '{text}'")
    return range(first, last + 1)


def _compare(arguments: argparse.Namespace, path: Path | None) -> dict:
    """One technique, or several whose files go to folders of their own and which one report has side by side."""
    jobs = _jobs(arguments)
    if arguments.target == "volume":
        raise UsageError("Cycles has no volume of light to compare with: compare --target image")
    if arguments.target != "image" and (arguments.dark or arguments.curves):
        raise UsageError("--dark and --curves are of camera images: compare --target image")
    if len(jobs) > 1 and arguments.save:
        raise UsageError("--save FILE goes with one method; without a name each method's folder gets a .blend")
    scene, view_layer = _open(arguments, path)
    if arguments.dark:
        try:
            dark_box(arguments.dark, scene)
        except ValueError as error:
            raise UsageError(f"--dark: {error}") from error
    folder, answers, results = _output(arguments), {}, {}
    for job in jobs:
        own = folder / job.method if len(jobs) > 1 else folder
        answers[job.method], results[job.method] = _baked(arguments, job, scene, view_layer, own)
    _progress(1.0, "Cycles")
    for result in results.values():
        lightmap_uvs.put_all({bpy.data.meshes[name, None]: uvs for name, uvs in result.uvs.items()})
    report = compare(
        results, scene, view_layer,
        samples=arguments.reference_samples, folder=folder, dark=arguments.dark, curves=arguments.curves,
    )  # fmt: skip
    _progress(None, "")
    answer = answers[jobs[0].method]
    if len(jobs) > 1:
        answer |= {"method": ",".join(answers), "seconds": sum(a["seconds"] for a in answers.values())}
        answer["stages"] = {f"{m} {k}": v for m, a in answers.items() for k, v in a["stages"].items()}
        for kind in ("outputs", "approximated", "warnings"):
            answer[kind] = list(dict.fromkeys(text for a in answers.values() for text in a[kind]))
    answer["outputs"] += [str(p) for p in report.paths]
    answer["metrics"] = report.metrics
    answer["stages"]["Cycles"] = report.seconds
    return answer


def _jobs(arguments: argparse.Namespace) -> list[Job]:
    """A job for each method that is named; a setting goes to those that have it."""
    methods = list(dict.fromkeys(name.strip() for name in arguments.method.split(",")))
    if len(methods) == 1:
        return [_job(arguments)]
    known = {m: {f.name for f in fields(METHODS[m].settings)} for m in methods if m in METHODS}
    jobs = []
    for method in methods:
        # What no method has stays, and is refused as ever.
        own = [
            text for text in arguments.set
            if (name := text.partition("=")[0]) in known.get(method, ()) or not any(name in k for k in known.values())
        ]  # fmt: skip
        jobs.append(_job(argparse.Namespace(**{**vars(arguments), "method": method, "set": own})))
    return jobs


_COMMANDS = {"bake": _bake, "compare": _compare, "check": _check}


def _baked(
    arguments: argparse.Namespace, job: Job, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, output: Path
) -> tuple[dict, Result]:
    """The bake that `bake` and `compare` share: files written, and what is said about it."""
    file = _save_file(arguments, output)
    if job.target == "vertices" and arguments.command == "bake" and file is None:
        raise UsageError("light at vertices is kept in the .blend: add --save, or --save FILE")
    begin = time.perf_counter()
    result = _followed(bake(scene, view_layer, job, output))

    written = time.perf_counter()
    outputs = [str(p) for p in export(result, output, view_layer.name)]
    if file is not None:
        store(result, scene, output)
        bpy.ops.wm.save_as_mainfile(filepath=str(file.resolve()), copy=True, compress=True, relative_remap=True)
        outputs.append(str(file))
    stages = {**result.stages, "write": time.perf_counter() - written}
    answer = {
        "method": job.method, "target": job.target, "device": result.device,
        "stages": {k: round(v, 4) for k, v in stages.items()}, "seconds": round(time.perf_counter() - begin, 4),
        "outputs": outputs, "metrics": None,
        "approximated": list(result.approximated), "warnings": list(result.warnings),
    }  # fmt: skip
    return answer, result


def _job(arguments: argparse.Namespace) -> Job:
    if arguments.method not in METHODS:
        raise NotThere(f"the method '{arguments.method}' is not there yet; there is {', '.join(METHODS)}")
    texts = {}
    for item in arguments.set:
        name, equals, value = item.partition("=")
        if not equals:
            raise UsageError(f"--set takes KEY=VALUE, not '{item}'")
        texts[name] = value
    texts |= {k: v for k in ("seed", "device") if (v := getattr(arguments, k)) is not None}
    return Job(
        method=arguments.method,
        target=arguments.target,
        objects=tuple(dict.fromkeys(name for text in arguments.objects.split(",") if (name := text.strip()))),
        resolution=arguments.resolution,
        settings=updated(METHODS[arguments.method].settings(), texts),
    )


def _open(arguments: argparse.Namespace, path: Path | None) -> tuple[bpy.types.Scene, bpy.types.ViewLayer]:
    """The scene to work on, at the frame asked for."""
    if path is not None:
        if not path.is_file():
            raise UsageError(f"there is no file {path}")
        try:
            bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False)
        except RuntimeError as error:
            finding = preflight.Finding(
                "UNREADABLE_FILE", "ERROR", path.name, f"Blender cannot read {path}: {error}".strip(),
                "Open it in Blender to see whether it is damaged or from a newer version",
            )  # fmt: skip
            raise Refused([finding]) from error
    scene = bpy.context.scene
    if arguments.frame is not None:
        # Blender's own bounds.
        if not -1048574 <= arguments.frame <= 1048574:
            raise UsageError(f"--frame is {arguments.frame}; it goes from -1048574 to 1048574")
        scene.frame_set(arguments.frame)
    return scene, bpy.context.view_layer


def _output(arguments: argparse.Namespace) -> Path:
    """The folder for files; one that begins with // lies beside the .blend, as everywhere in Blender."""
    if arguments.output:
        return Path(bpy.path.abspath(arguments.output))
    return Path(bpy.data.filepath).parent / "gi_bake" if bpy.data.filepath else Path("gi_bake")


def _save_file(arguments: argparse.Namespace, output: Path) -> Path | None:
    """The .blend that is to hold the results, None where none is. The open file is overwritten only by its name."""
    if arguments.save is None:
        return None
    opened = Path(bpy.data.filepath) if bpy.data.filepath else None
    if arguments.save:
        file = Path(bpy.path.abspath(arguments.save))
        if file.is_dir() or not file.absolute().parent.is_dir():
            raise UsageError(f"--save needs a file in a folder that exists, not {file}")
        return file
    file = output / (opened.name if opened else "untitled.blend")
    if opened and file.resolve() == opened.resolve():
        raise UsageError(
            f"{file} is the open file: name it with --save FILE to overwrite it, or choose another --output"
        )
    return file


def _followed(job) -> Result:
    """Exhausts a bake, with its progress in one line on standard error.

    An interrupt is heard between steps, which are short: raised at any place, it may leave a lock taken for good that
    the threads of a step wait for.
    """
    interrupts = []
    before = signal.signal(signal.SIGINT, lambda *_: interrupts.append(True))
    try:
        while True:
            fraction, stage = next(job)
            if interrupts:
                raise KeyboardInterrupt
            _progress(fraction, stage)
    except StopIteration as stop:
        return stop.value
    finally:
        signal.signal(signal.SIGINT, before)
        job.close()
        _progress(None, "")


def _progress(fraction: float | None, stage: str):
    """One updating line where a person watches; a log gets no thousand lines. None clears it."""
    if sys.stderr.isatty():
        sys.stderr.write("\r\x1b[K" if fraction is None else f"\r\x1b[K{fraction:4.0%}  {stage}")
        sys.stderr.flush()


def _finding(finding: dict) -> str:
    where = f" [{finding['object']}]" if finding["object"] else ""
    return f"{finding['severity']} {finding['code']}{where}: {finding['message']} {finding['remedy']}\n"


def _table(answer: dict) -> str:
    """What a person reads: stages and seconds, outputs, errors."""
    if "findings" in answer:
        size = answer["volume_bytes"]
        volume = f"the volume takes at most {size / 2**20:.0f} MB\n" if size else ""
        maps = "".join(
            f"lightmap {m['name']}: {m['width']} × {m['height']} texels, {m['padding']} free around islands"
            + (f", {len(m['objects'])} objects\n" if len(m["objects"]) > 1 else "\n")
            + "".join(f"  {name}: {side}²\n" for name, side in m["objects"].items() if len(m["objects"]) > 1)
            for m in answer["lightmaps"]
        )
        return ("".join(_finding(f) for f in answer["findings"]) or "ready to bake\n") + volume + maps
    lines = [f"{answer['method']} {answer['target']} on {answer['device']}"]
    wide = max(10, 1 + max(map(len, answer["stages"]), default=0))
    lines += [f"  {stage:<{wide}}{seconds:8.2f} s" for stage, seconds in answer["stages"].items()]
    lines += [f"  {'bake':<{wide}}{answer['seconds']:8.2f} s"]
    for technique, found in (answer["metrics"] or {}).items():
        for name, values in found.items():
            lines.append(f"  {technique}, {name}: " + "  ".join(f"{k} {v:.4g}" for k, v in values.items()))
    lines += [f"approximated: {text}" for text in answer["approximated"]]
    lines += [f"warning: {text}" for text in answer["warnings"]]
    lines += [f"wrote {path}" for path in answer["outputs"]]
    return "\n".join(lines) + "\n"


def _settings_help() -> str:
    lines = []
    for method, technique in METHODS.items():
        lines.append(f"settings of {method} (--set KEY=VALUE):")
        for f in fields(technique.settings):
            m = f.metadata
            allowed = "|".join(m["choices"]) if m["choices"] else f"{m['low']}…{m['high']} {m['unit']}".strip()
            allowed = {bool: "true|false", str: allowed if m["choices"] else "text"}.get(type(f.default), allowed)
            lines.append(f"  {f.name} = {f.default}  ({allowed})\n      {m['description']}")
    return "\n".join(lines)
