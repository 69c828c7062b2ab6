#!/usr/bin/python3
"""Judges a state of states.h5 from outside: is it an equilibrium with all its contacts?

    judge.py states.h5 [...] [--increment N] [--quiet]

Exit code 0: right; 1: wrong, with the reasons; 2: not to be read. A state that is still damped (proximal
term) is judged by its contacts alone. Shares no code with the programs that it judges.
"""

import argparse
import pathlib
import sys

import h5py

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import checks  # noqa: E402
from cells import is_cell, laid_out  # noqa: E402
from states import Mesh, State  # noqa: E402


def verdict(file, increment=-1):
    """Complaints about one saved state of an open file, by check."""
    n = int(file["n_increments"][()])
    i = increment % n
    mesh = Mesh(file)
    state, start = State(file, i, mesh), State(file, 0, mesh)
    found = {"finite": checks.finite(state)}
    if found["finite"] or i == 0:
        return found
    found["friction"] = checks.friction_law(state)
    before = State(file, i - 1, mesh)
    cell = is_cell(mesh)
    if cell:
        mesh, (state, start, before) = laid_out(mesh, [state, start, before])
    found["contacts"], found["deep"] = checks.contacts_complete(state)
    if not checks.is_at_rest(state):
        found["deep"] = []  # fibers that are on their way may still lie in each other
    else:
        if not cell:
            found["groups"] = checks.group_balance(state)
        found["fibers"] = checks.fiber_balance(state, start)
    if not state.settings.get("separate_yarns", False):
        found["passed"] = checks.passed_through(before, state)
    return found


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("states", nargs="+")
    parser.add_argument("--increment", type=int, default=-1, help="saved state, from the end where negative")
    parser.add_argument("--every", action="store_true", help="judge all saved states, not one")
    parser.add_argument("--quiet", action="store_true", help="only what is wrong")
    options = parser.parse_args()
    wrong = 0
    for name in options.states:
        try:
            with h5py.File(name, "r", swmr=True) as file:
                n = int(file["n_increments"][()])
                which = range(1, n) if options.every else [options.increment]
                found = {}
                for i in which:
                    for check, complaints in verdict(file, i).items():
                        found.setdefault(check, []).extend(
                            (f"state {i}: " if options.every else "") + c for c in complaints
                        )
        except (OSError, KeyError) as error:
            print(f"{name}: {error}")
            return 2
        bad = {k: v for k, v in found.items() if v}
        wrong += bool(bad)
        if bad:
            print(f"{name}: wrong")
        elif not options.quiet:
            print(f"{name}: right ({', '.join(found)})")
        for check, complaints in bad.items():
            for text in complaints[:3]:
                print(f"  {check}: {text}")
            if len(complaints) > 3:
                print(f"  {check}: and {len(complaints) - 3} more")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
