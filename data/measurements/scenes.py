#!/usr/bin/python3
"""Runs the small shipped scenes through the whole workflow, and writes the first table of scenes.md.

    data/measurements/scenes.py BIN [SCENE ...] [--jobs N] [--write data/measurements/scenes.md]

Each runs in one thread and without pictures. CPU time is user time of the whole workflow, memory its peak, imbalance
that of the energy over the external work. Forces are the last ones: of a weave those of the sides of warp and weft,
else of the body and dof with the largest product of force and way in the last stage. Exit code 1 if a run does not
reach its end.
"""

import argparse
import concurrent.futures
import csv
import datetime
import json
import os
import pathlib
import subprocess
import sys
import tempfile

DATA = pathlib.Path(__file__).resolve().parent.parent
SCENES = [
    "scenes/plain_small",
    "scenes/twill_small",
    "scenes/single_yarn",
    "scenes/twisted_bundle",
    "scenes/capstan",
    "scenes/cantilever",
    "scenes/roll_up",
    "scenes/two_crossing_fibers",
    "fabrics/gauze",
    "fabrics/cell",
    "fabrics/twill_2_1",
]
BEGIN = "<!-- written by data/measurements/scenes.py -->"
END = "<!-- end of what scenes.py writes -->"
HEAD = [
    "scene", "fibers, dofs", "contact elements", "increments (cut)", "iterations", "crossings", "penetration / R",
    "imbalance", "forces at the end", "CPU, s", "MB",
]  # fmt: skip


def run(program, scene, out):
    """Seconds of CPU time; what went wrong, or nothing."""
    # Pictures take a display and gnuplot, and seconds; there are none to be found.
    environment = {**os.environ, "PATH": "/nowhere", "DISPLAY": ""}
    command = [program, DATA / f"{scene}.toml", "--threads", "1", "--out", out]
    with tempfile.TemporaryFile("w+") as messages:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=messages, env=environment)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        messages.seek(0)
        return usage.ru_utime, "" if process.returncode == 0 else messages.read().strip() or "failed"


def in_words(newtons):
    for scale, unit in ((1, "N"), (1e3, "mN"), (1e6, "µN"), (1e9, "nN")):
        if abs(newtons) * scale >= 1:
            break
    return f"{newtons * scale:.4g} {unit}"


def forces(out):
    """Of the last row of curves.csv."""
    with open(out / "curves.csv") as file:
        rows = list(csv.DictReader(file))
    last = {name: float(value) for name, value in rows[-1].items() if name != "stage"}
    if "warp_force_N" in last:
        return ", ".join(f"{system} {in_words(last[f'{system}_force_N'])}" for system in ("warp", "weft"))
    first = next(row for row in rows if row["stage"] == rows[-1]["stage"])
    worked = {}
    for motion, unit in (("_m", "_N"), ("_rad", "_Nm")):
        for column in [column for column in last if column.endswith(motion)]:
            reaction = column.removesuffix(motion) + unit
            worked[reaction] = abs((last[column] - float(first[column])) * last[reaction])
    if not worked:
        return ""
    body, _, dof = max(worked, key=worked.get).rpartition(".")
    dof, unit = dof.split("_")
    return f"{body}, {dof}: {in_words(last[f'{body}.{dof}_{unit}'])}" + (" m" if unit == "Nm" else "")


def row(*cells):
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def line(scene, s, out, seconds):
    return row(
        pathlib.Path(scene).name,
        f"{s['n_fibers']}, {s['n_dofs']:,}",
        f"{s['n_contact_elements_max']:,}",
        f"{s['n_increments']} ({s['n_cut_increments']})",
        s["n_newton_iterations"],
        f"{s['n_crossings_ok']}/{s['n_crossings']}" if s.get("n_crossings") else "",
        f"{s['max_penetration_over_radius']:.3f}",
        f"{100 * s['energy']['imbalance'] / s['energy']['external_work']:.2g} %",
        forces(out),
        f"{seconds:.1f}",
        f"{1e-6 * s['peak_memory_bytes']:.0f}",
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binaries", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*", default=SCENES, help="without .toml, from data on")
    parser.add_argument("--jobs", type=int, default=1, help="scenes at the same time")
    parser.add_argument("--write", type=pathlib.Path, help="the page whose table is replaced")
    options = parser.parse_args()
    scenes = options.scenes or SCENES
    program = options.binaries.resolve() / "run_workflow"
    made = datetime.date.fromtimestamp(program.stat().st_mtime)
    lines = [row(*HEAD), "|" + " --- |" * len(HEAD)]
    failed = False
    with tempfile.TemporaryDirectory(prefix="scenes_") as temporary:
        folders = [pathlib.Path(temporary) / scene.replace("/", "_") for scene in scenes]
        pool = concurrent.futures.ThreadPoolExecutor(options.jobs)
        runs = pool.map(lambda scene, out: run(program, scene, out), scenes, folders)
        for scene, out, (seconds, failure) in zip(scenes, folders, runs):
            if failure:
                failed = True
                print(f"{scene}: {failure}", file=sys.stderr)
                continue
            lines.append(line(scene, json.loads((out / "summary.json").read_text()), out, seconds))
            print(lines[-1], flush=True)
    if options.write and not failed:
        page = options.write.read_text()
        before, rest = page.split(BEGIN)
        after = rest.split(END)[1]
        table = "\n".join(["", "", f"With programs built on {made}.", "", *lines, "", ""])
        options.write.write_text(before + BEGIN + table + END + after)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
