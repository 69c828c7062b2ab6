"""Runs of the programs: a scene from a dict, a study of parameters."""

import itertools
import os
import shutil
import subprocess
from pathlib import Path

import pandas as pd

from .run import open_run
from .scene import changed, scene_text


class ProgramFailed(RuntimeError):
    """A program ended with another exit code than 0: `code`, and what it said."""

    def __init__(self, command, code, said):
        super().__init__(f"{' '.join(map(str, command))}: exit code {code}\n{said}")
        self.code, self.said = code, said


def program(name):
    """Where a program of Trame is: in the folder TRAME_BIN, on the PATH, or built beside this file."""
    folders = [os.environ.get("TRAME_BIN"), *os.environ.get("PATH", "").split(os.pathsep),
               Path(__file__).resolve().parents[3] / "build" / "release" / "bin"]
    found = shutil.which(name, path=os.pathsep.join(str(folder) for folder in folders if folder))
    if not found:
        raise FileNotFoundError(f"{name}: not in TRAME_BIN, not on the PATH, and not built in build/release/bin")
    return found


def run_scene(scene, folder, strains=False, threads=None, arguments=()):
    """Runs a scene: a dict, or the text or the path of a TOML file. Results of an earlier run in `folder` are replaced.
    `strains`: with strains of yarns and the report (run_workflow), else fibers alone (simulate_fibers). Raises
    ProgramFailed with what the program said; a run that ended early has left its results up to there."""
    folder = Path(folder)
    file = _scene_file(scene, folder)
    command = [program("run_workflow" if strains else "simulate_fibers"), file, "--out", folder, "--overwrite",
               *(["--threads", str(threads)] if threads else []), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, errors="replace")
    if done.returncode != 0:
        raise ProgramFailed(command, done.returncode, done.stderr or done.stdout)
    return open_run(folder)


def _scene_file(scene, folder):
    if isinstance(scene, Path) or (isinstance(scene, str) and "\n" not in scene):
        return scene
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{folder.name}.toml"
    file.write_text(scene if isinstance(scene, str) else scene_text(scene))
    return file


def study(scene, parameters, folder, measure=None, jobs=1, **options):
    """Runs a scene for all combinations of `parameters`, {"contact.friction_coefficient": [0.1, 0.3], …}, each in a
    folder of its own, one after the other or `jobs` at a time. Returns a table: the parameters, the folder, the status,
    and what `measure(run)`, a dict, says of each. A run that fails has its message as status and is no end of the
    others."""
    from concurrent.futures import ThreadPoolExecutor

    cases = [dict(zip(parameters, values)) for values in itertools.product(*parameters.values())]

    def one(number_and_case):
        number, case = number_and_case
        row = {**case, "folder": str(Path(folder) / f"{number:03d}")}
        try:
            with run_scene(changed(scene, case), row["folder"], **options) as run:
                row["status"] = run.summary()["status"]
                row.update(measure(run) if measure else {})
        except ProgramFailed as failure:
            row["status"] = f"exit code {failure.code}: {failure.said.strip()}"
        return row

    with ThreadPoolExecutor(max_workers=jobs) as pool:
        return pd.DataFrame(list(pool.map(one, enumerate(cases))))
