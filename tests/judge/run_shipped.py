#!/usr/bin/python3
"""Runs shipped scenes and judges every saved state of theirs.

    run_shipped.py BIN FOLDER_OF_SCENES [NAME ...]

Without names: all but the patches of full size. Exit code 1 if one does not end or has a state that is wrong.
"""

import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import h5py  # noqa: E402
from judge import verdict  # noqa: E402

FULL_SIZE = {"plain", "twill"}


def main():
    binary, scenes = pathlib.Path(sys.argv[1]) / "simulate_fibers", pathlib.Path(sys.argv[2])
    names = sys.argv[3:] or sorted(f.stem for f in scenes.glob("*.toml") if f.stem not in FULL_SIZE)
    wrong = 0
    with tempfile.TemporaryDirectory(prefix="shipped_") as folder:
        for name in names:
            out = pathlib.Path(folder) / name
            run = subprocess.run(
                [binary, scenes / f"{name}.toml", "--threads", "1", "--out", out],
                capture_output=True,
                text=True,
                check=False,
            )
            complaints = [f"exit code {run.returncode}"] if run.returncode else []
            if not run.returncode:
                with h5py.File(out / "states.h5", "r") as file:
                    for i in range(1, int(file["n_increments"][()])):
                        complaints += [
                            f"state {i}: {check}: {c}"
                            for check, found in verdict(file, i).items()
                            for c in found
                        ]
            wrong += bool(complaints)
            print(f"{name}: {'wrong' if complaints else 'right'}", flush=True)
            for c in complaints[:5] + ([f"and {len(complaints) - 5} more"] if len(complaints) > 5 else []):
                print(f"  {c}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
