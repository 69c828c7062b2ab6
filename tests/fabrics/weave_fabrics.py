#!/usr/bin/python3
"""Weaves the fabrics of a folder with the stages that the program chooses, and prints a table of them.

    weave_fabrics.py BIN FOLDER_OF_SCENES [NAME ...]

Exit code 1 if one does not reach its end, has a yarn on the wrong side of another, or fibers deeper in each other than
5 % of their radius.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

MOST_PENETRATION = 0.05


def main():
    binary, scenes = pathlib.Path(sys.argv[1]) / "simulate_fibers", pathlib.Path(sys.argv[2])
    names = sys.argv[3:] or sorted(f.stem for f in scenes.glob("*.toml"))
    failures = 0
    print("| fabric | fibers | increments (cut) | iterations | unstable | penetration / R | |\n|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="fabrics_") as folder:
        for name in names:
            out = pathlib.Path(folder) / name
            command = [binary, scenes / f"{name}.toml", "--threads", "1", "--out", out]
            run = subprocess.run(command, capture_output=True, text=True, check=False)
            if not (out / "summary.json").exists():
                failures += 1
                print(f"| {name} | | | | | | exit code {run.returncode}: {run.stderr.strip()} |", flush=True)
                continue
            s = json.loads((out / "summary.json").read_text())
            is_woven = (
                run.returncode == 0
                and s["status"] == "done"
                and s["crossing_order_ok"]
                and s["max_penetration_over_radius"] <= MOST_PENETRATION
            )
            failures += not is_woven
            print(
                f"| {name} | {s['n_fibers']} | {s['n_increments']} ({s['n_cut_increments']}) | "
                f"{s['n_newton_iterations']} | {s['n_unstable_increments']} | {s['max_penetration_over_radius']:.3f} | "
                f"{'woven' if is_woven else s['message'] or 'not as it should be'} |",
                flush=True,
            )
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
