#!/usr/bin/python3
"""Published and closed forms with default settings: runs the scenes of rows.py and compares.

    closed_forms.py BIN                        all of them, a line each
    closed_forms.py BIN --case NAME [...]      some; exit code 1 if a value is off by more than its tolerance
    closed_forms.py BIN --write FILE           all of them, and the table into FILE between its two marks
    closed_forms.py --list                     their names
    closed_forms.py --scenes FOLDER            writes the scenes
"""

import argparse
import pathlib
import resource
import subprocess
import sys
import tempfile

import h5py
import numpy as np
from rows import BUILDERS, Saved

MARKS = "<!-- closed forms: written by tests/closed_forms/closed_forms.py -->", "<!-- end of closed forms -->"


def run(case, binary, folder, late):
    """(CPU seconds, path of the states or None, what the program said) of a case."""
    scene, out = folder / f"{case.name}.toml", folder / case.name
    scene.write_text(case.scene.text())
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        done = subprocess.run(
            [binary, scene, "--threads", "1", "--out", out, "--overwrite"],
            capture_output=True,
            text=True,
            check=False,
            timeout=late,
        )
    except subprocess.TimeoutExpired:
        return late, None, f"still running after {late:g} s"
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if done.returncode not in (0, 3):
        return seconds, None, f"exit code {done.returncode}: {done.stderr.strip()}"
    if done.returncode == 3:
        return (
            seconds,
            out / "states.h5",
            next(line for line in done.stdout.splitlines() if "gave up" in line),
        )
    return seconds, out / "states.h5", ""


def shown(value):
    return ", ".join(f"{x:.5g}" for x in np.atleast_1d(value))


def results(case, binary, folder, late=500):
    """For each row: (row, value, error, within tolerance, CPU seconds, said)."""
    seconds, states, said = run(case, binary, folder, late)
    for row in case.rows:
        if states is None or (said and not (row.may_end and row.may_end in said)):
            yield row, None, np.inf, False, seconds, said
            continue
        with h5py.File(states, "r") as file:
            value = np.asarray(row.value(Saved(file)), float)
        expected = np.asarray(row.expected, float)
        if not np.isfinite(value).all():
            yield row, None, np.inf, False, seconds, said
            continue
        scale = 1.0 if row.absolute else np.linalg.norm(expected)
        error = np.linalg.norm(value - expected) / scale
        yield row, value, error, bool(error <= row.tolerance), seconds, said


def cell(text):
    return text.replace("|", "\\|")


def table_line(row, value, error, within, seconds):
    off = "—" if value is None else (f"{error:.1e}" if row.absolute else f"{100 * error:.2g} %")
    verdict = "" if within else " **✗**"
    return (
        f"| {cell(row.what)} | {cell(row.source)} | {shown(row.expected)} | "
        f"{'none' if value is None else shown(value)} | {off}{verdict} | {seconds:.1f} s | {row.reason} |"
    )


def write_table(file, lines):
    text = file.read_text()
    first, last = text.index(MARKS[0]) + len(MARKS[0]), text.index(MARKS[1])
    head = [
        "",
        "| | reference | value | by default | error | CPU time | allowed above 1 % because |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    file.write_text(text[:first] + "\n".join(head + lines) + "\n" + text[last:])


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("bin", type=pathlib.Path, nargs="?")
    p.add_argument("--case", nargs="+", choices=BUILDERS, default=list(BUILDERS))
    p.add_argument("--write", type=pathlib.Path)
    p.add_argument("--list", action="store_true")
    p.add_argument("--scenes", type=pathlib.Path)
    p.add_argument("--late", type=float, default=500, help="seconds after which a run is ended")
    p.add_argument("--keep", type=pathlib.Path, help="folder for scenes and results")
    o = p.parse_args()
    if o.list:
        print("\n".join(BUILDERS))
        return 0
    if o.scenes:
        o.scenes.mkdir(parents=True, exist_ok=True)
        for name in o.case:
            (o.scenes / f"{name}.toml").write_text(BUILDERS[name]().scene.text())
        return 0
    if o.bin is None:
        p.error("needs BIN")
    lines, n_off = [], 0
    with tempfile.TemporaryDirectory(prefix="closed_forms_") as temporary:
        folder = o.keep or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for name in o.case:
            for row, value, error, within, seconds, said in results(
                BUILDERS[name](), o.bin / "simulate_fibers", folder, o.late
            ):
                n_off += not within
                lines.append(table_line(row, value, error, within, seconds))
                print(
                    f"{name}: {row.what}: expected {shown(row.expected)}, "
                    f"{'none' if value is None else shown(value)}, error {error:.2e}, {seconds:.1f} s"
                    f"{'' if within else '  OFF'} {said}",
                    flush=True,
                )
    print(f"{len(lines) - n_off} of {len(lines)} rows are within their tolerance")
    if o.write:
        write_table(o.write, lines)
    return 1 if n_off else 0


if __name__ == "__main__":
    sys.exit(main())
