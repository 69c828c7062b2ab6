#!/usr/bin/python3
"""Ends a run at random moments, goes on with it each time, and compares what it leaves with what an uninterrupted run
does: states, curves and summary, to the bit, but for times.

    resume_soak.py BIN [--ends N] [--scene SCENE] [--seed N]     BIN: folder of simulate_fibers

A run is ended by SIGKILL, by SIGTERM, or by a limit of its files' size, as a full disk would, with 1 and 2 threads in
turn."""

import argparse
import json
import pathlib
import random
import resource
import signal
import subprocess
import sys
import tempfile

import h5py

# What a run measures of itself, not of the scene.
TIMES = {"solver/seconds"}
MACHINE = {"seconds", "threads", "peak_memory_bytes"}
DONE, ENDED_EARLY = 0, 3


def datasets(file):
    found = {}
    with h5py.File(file, "r", swmr=True) as states:
        n = int(states["n_increments"][()])

        def visit(name, item):
            if not isinstance(item, h5py.Dataset) or name in TIMES or name.startswith("continuation"):
                return
            text = item.dtype.kind == "O"
            found[name] = (item.shape, list(item[:]) if text else item[()].tobytes())

        states.visititems(visit)
    return n, found


def summary(folder):
    json_text = (folder / "summary.json").read_text()
    return {key: value for key, value in json.loads(json_text).items() if key not in MACHINE}


def differences(a, b):
    """What two folders of results differ in."""
    (n_a, ours), (n_b, theirs) = datasets(a / "states.h5"), datasets(b / "states.h5")
    found = [] if n_a == n_b else ["n_increments"]
    found += [name for name in ours.keys() | theirs.keys() if ours.get(name) != theirs.get(name)]
    x, y = summary(a), summary(b)
    found += [f"summary.json: {key}" for key in x.keys() | y.keys() if x.get(key) != y.get(key)]
    curves = [folder / "curves.csv" for folder in (a, b)]
    if curves[0].exists() != curves[1].exists() or (
        curves[0].exists() and curves[0].read_bytes() != curves[1].read_bytes()
    ):
        found.append("curves.csv")
    return found


class Soak:
    def __init__(self, options, folder):
        self.program = [pathlib.Path(options.bin) / "simulate_fibers", options.scene]
        self.random = random.Random(options.seed)
        self.folder, self.n_ends, self.n_starts = folder, 0, 0
        self.patience = 1.0  # seconds, within which a run is ended; grows where it gets nowhere

    def run_whole(self):
        whole = self.folder / "whole"
        subprocess.run(
            [*self.program, "--threads", "1", "--out", whole], check=True, stdout=subprocess.DEVNULL
        )
        return whole

    def saved(self, out):
        states = out / "states.h5"
        return datasets(states)[0] if states.exists() else 0

    def run_and_end(self, out, how):
        """Runs until it is done or is ended; returns whether it is done."""
        self.n_starts += 1
        size = (out / "states.h5").stat().st_size if (out / "states.h5").exists() else 0
        limit = size + self.random.randrange(1, 1_000_000)
        run = subprocess.Popen(
            [*self.program, "--resume", "--threads", str(1 + self.n_starts % 2), "--out", out],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            preexec_fn=lambda: how == "full disk"
            and resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY)),
        )
        try:
            _, told = run.communicate(timeout=None if how == "full disk" else self.random.uniform(0, self.patience))
        except subprocess.TimeoutExpired:
            run.send_signal(signal.SIGKILL if how == "kill" else signal.SIGTERM)
            _, told = run.communicate()
            self.n_ends += 1
            if how == "kill" or run.returncode == -signal.SIGTERM:
                return False  # by SIGTERM before the program has begun to listen
            if run.returncode != DONE:
                sys.exit(f"exit code {run.returncode} after SIGTERM: {told.decode()}")
            # It may have been over just before.
            return (out / "summary.json").exists() and summary(out).get("status") == "done"
        if run.returncode == ENDED_EARLY and how == "full disk":
            self.n_ends += 1
            return False
        if run.returncode != DONE:
            sys.exit(f"exit code {run.returncode}, {how}: {told.decode()}")
        return True

    def run_in_pieces(self, out):
        ways = ["kill", "term", "full disk"]
        done = False
        while not done:
            before = self.saved(out)
            done = self.run_and_end(out, self.random.choice(ways))
            after = self.saved(out)
            if after < before - 1:  # one that SIGTERM has saved gives way to those of the run itself
                sys.exit(f"{before - after} saved states were lost")
            self.patience = max(1.0, self.patience * (0.9 if after > before else 1.3))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin")
    parser.add_argument("--ends", type=int, default=100)
    parser.add_argument("--scene", default="plain_small")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="resume_") as folder:
        soak = Soak(options, pathlib.Path(folder))
        whole = soak.run_whole()
        n_runs = 0
        while soak.n_ends < options.ends:
            out = soak.folder / f"pieces_{n_runs}"
            soak.run_in_pieces(out)
            n_runs += 1
            if found := differences(whole, out):
                print(f"after {soak.n_ends} ends, run {n_runs} differs: {', '.join(found)}")
                return 1
            print(f"{n_runs} runs, ended {soak.n_ends} times: each as if it had not been", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
