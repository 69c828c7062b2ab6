#!/usr/bin/python3
"""Weaves the fabrics of a folder with the stages that the program chooses, and prints two tables: what became of
each, and its facts beside those of its source (sources.csv of the folder).

    weave_fabrics.py BIN FOLDER_OF_SCENES [NAME ...] [--jobs N] [--keep DIR] [--write FILE]

A fabric is woven if its run reaches its end with every crossing in order and no fiber deeper in another than 5 % of
its radius. Exit code 1 if one is not that is not known for it, or one is that is. With --keep, results stay in DIR, and
runs that are there go on from where they are.
"""

import argparse
import concurrent.futures
import csv
import json
import os
import pathlib
import subprocess
import sys
import tempfile

MOST_PENETRATION = 0.05

# Why they are not woven.
ARC = "fibers bend as sharply as those that they pass, contact is an arc instead of a point and does not come to rest"
KNOWN = {
    "mesh_100": ARC,
    "mesh_pet_190": ARC,
    "tight": "closer than Ashenhurst's limit, yarns find no room to part, and ends of fibers come to lie in others",
}
# What of the usual list cannot be written down as a scene.
NOT_WRITTEN = {
    "leno": "warps that twist about each other: yarns lie above or below, crossing by crossing",
    "triaxial braid": "three systems",
}
# Fact, key in summary.json, scale, column of sources.csv.
FACTS = [
    ("g/m²", "areal_density_kg_m2", 1e3, "areal_density_g_m2"),
    ("thickness, µm", "thickness_m", 1e6, "thickness_um"),
    ("cover, %", "projected_cover", 100, "cover_percent"),
]


def weave(program, scene, out):
    """Summary of the run, or None and why there is none; CPU seconds, also of earlier parts of it."""
    cpu = out.with_suffix(".cpu")
    command = [program, scene, "--threads", "1", "--out", out, "--resume"]
    # Pictures take a display and gnuplot, and seconds; there are none to be found.
    environment = {**os.environ, "PATH": "/nowhere", "DISPLAY": ""}
    with tempfile.TemporaryFile("w+") as messages:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=messages, env=environment)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        messages.seek(0)
        told = messages.read().strip()
    seconds = usage.ru_utime + (float(cpu.read_text()) if cpu.exists() else 0)
    cpu.write_text(f"{seconds}\n")
    if not (out / "summary.json").exists():
        return None, f"exit code {process.returncode}: {told}", seconds
    return json.loads((out / "summary.json").read_text()), "", seconds


def is_woven(s):
    return s["status"] == "done" and s["crossing_order_ok"] and s["max_penetration_over_radius"] <= MOST_PENETRATION


def why_not(name, s):
    found = s["message"].split(". ")[0].split("; ")[0] or "; ".join(s["warnings"]) or "fibers lie in each other"
    return f"no: {KNOWN[name]} ({found})" if name in KNOWN else f"no: {found}"


def row(*cells):
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def head(*cells):
    return row(*cells) + "\n" + "|" + " --- |" * len(cells)


def weaving_row(name, s, seconds):
    return row(
        name,
        "yes" if is_woven(s) else why_not(name, s),
        s["n_fibers"],
        f"{s['n_increments']} ({s['n_cut_increments']})",
        s["n_newton_iterations"],
        s["n_unstable_increments"],
        f"{seconds:.1f}",
        f"{1e-6 * s['peak_memory_bytes']:.0f}",
        f"{s['max_penetration_over_radius']:.3f}",
        f"{s['n_crossings_ok']}/{s['n_crossings']}",
        f"{s['force_imbalance']:.0e}",
    )


def facts_row(name, s, source):
    fabric = s["fabric"]
    cells = []
    for _, key, scale, column in FACTS:
        theirs = source.get(column)
        cells.append(f"{scale * fabric[key]:.3g}" + (f" ({theirs})" if theirs else ""))
    for system in (fabric["warp"], fabric["weft"]):
        cells.append(f"{1e-2 * system['sett_per_m']:.1f}")
    for system in (fabric["warp"], fabric["weft"]):
        cells.append(f"{100 * system['crimp']:.2f} ± {100 * system['crimp_deviation']:.2f}")
    for system in (fabric["warp"], fabric["weft"]):
        cells.append(f"{1e6 * system['width_m']:.0f} × {1e6 * system['height_m']:.0f}")
    return row(name, *cells, f"{100 * fabric['volume_fraction']:.0f}", source.get("source", "typical value"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binaries", type=pathlib.Path)
    parser.add_argument("scenes", type=pathlib.Path)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--jobs", type=int, default=1, help="fabrics at the same time")
    parser.add_argument("--keep", type=pathlib.Path)
    parser.add_argument("--write", type=pathlib.Path, help="the tables, as a page")
    options = parser.parse_args()
    with open(options.scenes / "sources.csv") as file:
        sources = {line["fabric"]: line for line in csv.DictReader(file)}
    names = options.names or sorted(f.stem for f in options.scenes.glob("*.toml"))
    weaving = [
        head("fabric", "woven", "fibers", "increments (cut)", "iterations", "unstable", "CPU, s", "MB",
             "penetration / R", "order", "imbalance")
    ]  # fmt: skip
    facts = [
        head("fabric", *(fact[0] for fact in FACTS), "warps / cm", "wefts / cm", "crimp of warp, %", "of weft, %",
             "warp, µm", "weft, µm", "fiber volume, %", "source")
    ]  # fmt: skip
    unexpected = []
    with tempfile.TemporaryDirectory(prefix="fabrics_") as temporary:
        folder = options.keep or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        program = options.binaries / "run_workflow"
        pool = concurrent.futures.ThreadPoolExecutor(options.jobs)
        runs = pool.map(lambda name: weave(program, options.scenes / f"{name}.toml", folder / name), names)
        for name, (s, failure, seconds) in zip(names, runs):
            if (s is not None and is_woven(s)) == (name in KNOWN):
                unexpected.append(name)
            weaving.append(weaving_row(name, s, seconds) if s else row(name, f"no: {failure}"))
            if s and "fabric" in s and is_woven(s):
                facts.append(facts_row(name, s, sources.get(name, {})))
            print(weaving[-1], flush=True)
    if not options.names:
        weaving += [row(name, f"cannot be written: {why}") for name, why in NOT_WRITTEN.items()]
    text = "\n".join([*weaving, "", *facts, ""])
    print("\n" + text)
    if options.write:
        page = options.write.read_text().split("<!-- tables -->")[0] if options.write.exists() else ""
        options.write.write_text(page + "<!-- tables -->\n\n" + text)
    for name in unexpected:
        print(f"{name}: {'is woven, which was not known' if name in KNOWN else 'is not as it should be'}")
    return 1 if unexpected else 0


if __name__ == "__main__":
    sys.exit(main())
