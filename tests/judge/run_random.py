#!/usr/bin/python3
"""Runs random scenes and judges the last state of those that say "done".

    run_random.py BIN [--first SEED] [--count N] [--seconds S] [--kind K] [--out FOLDER] [--late S] [--jobs N]

BIN is the folder of simulate_fibers. Stops after `count` scenes or `seconds`, whichever is first. Prints a
line for each scene that is not right and a table of counts: right, wrong, gave up (3), refused (2), late,
other. Exit code 1 if any is wrong, refused or other (a random scene is valid), or fewer than `--done` of
them end.
"""

import argparse
import collections
import concurrent.futures
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import h5py  # noqa: E402
from judge import verdict  # noqa: E402
from random_scenes import KINDS, scene_of  # noqa: E402

OUTCOMES = ("right", "wrong", "gave up", "refused", "late", "other")


def run_one(binary, folder, seed, kind, late, keep):
    """(seed, kind, outcome, text, seconds) of a scene."""
    kind, text = scene_of(seed, kind)
    scene, out = folder / f"{kind}_{seed}.toml", folder / f"{kind}_{seed}"
    scene.write_text(text)
    start = time.monotonic()
    try:
        run = subprocess.run(
            [binary, scene, "--threads", "1", "--out", out, "--overwrite"],
            capture_output=True,
            text=True,
            timeout=late,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return seed, kind, "late", f"still running after {late:g} s", late
    seconds = time.monotonic() - start
    message = (run.stderr or run.stdout).strip().splitlines()
    outcome, said = {3: "gave up", 2: "refused"}.get(run.returncode, "other"), message[-1] if message else ""
    if run.returncode == 3:
        said = next((line for line in run.stdout.splitlines() if "gave up" in line), said)
    if run.returncode == 0:
        with h5py.File(out / "states.h5", "r") as file:
            found = {k: v for k, v in verdict(file).items() if v}
        outcome, said = ("wrong" if found else "right"), "; ".join(f"{k}: {v[0]}" for k, v in found.items())
    if not keep:
        shutil.rmtree(out, ignore_errors=True)
    return seed, kind, outcome, said, seconds


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("bin", type=pathlib.Path)
    p.add_argument("--first", type=int, default=1)
    p.add_argument("--count", type=int, default=10**9)
    p.add_argument("--seconds", type=float, default=float("inf"))
    p.add_argument("--kind", choices=KINDS)
    p.add_argument(
        "--out", type=pathlib.Path, help="keeps scenes and results here; else in a temporary folder"
    )
    p.add_argument("--late", type=float, default=60, help="seconds after which a run is ended")
    p.add_argument("--jobs", type=int, default=1)
    p.add_argument("--done", type=float, default=0, help="least share of scenes that must end right")
    o = p.parse_args()
    if o.count == 10**9 and o.seconds == float("inf"):
        p.error("needs --count or --seconds")
    folder = o.out or pathlib.Path(tempfile.mkdtemp(prefix="random_scenes_"))
    folder.mkdir(parents=True, exist_ok=True)
    counts = collections.defaultdict(collections.Counter)
    end = time.monotonic() + o.seconds
    total_seconds = 0.0
    with concurrent.futures.ThreadPoolExecutor(o.jobs) as pool:
        waiting, seed = set(), o.first
        while True:
            while len(waiting) < o.jobs and seed < o.first + o.count and time.monotonic() < end:
                waiting.add(
                    pool.submit(
                        run_one, o.bin / "simulate_fibers", folder, seed, o.kind, o.late, o.out is not None
                    )
                )
                seed += 1
            if not waiting:
                break
            done, waiting = concurrent.futures.wait(waiting, return_when=concurrent.futures.FIRST_COMPLETED)
            for future in done:
                number, kind, outcome, said, seconds = future.result()
                counts[kind][outcome] += 1
                total_seconds += seconds
                if outcome != "right":
                    print(f"{number} {kind}: {outcome}: {said}", flush=True)
    all_of_them = sum(counts.values(), collections.Counter())
    print(f"{'':10}" + "".join(f"{x:>9}" for x in OUTCOMES))
    for kind in KINDS:
        if kind in counts:
            print(f"{kind:10}" + "".join(f"{counts[kind][x]:9}" for x in OUTCOMES))
    print(
        f"{'all':10}" + "".join(f"{all_of_them[x]:9}" for x in OUTCOMES) + f"   {total_seconds:.0f} s of runs"
    )
    if not o.out:
        shutil.rmtree(folder)
    n = sum(all_of_them.values())
    bad = all_of_them["wrong"] + all_of_them["refused"] + all_of_them["other"]
    sys.exit(1 if bad or n == 0 or all_of_them["right"] < o.done * n else 0)


if __name__ == "__main__":
    main()
