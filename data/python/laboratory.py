#!/usr/bin/python3
"""The tests of the laboratory on fabrics: one page of curves, laboratory.png and .svg, and what must hold of them.

    data/python/laboratory.py results/laboratory data/scenes/plain_small.toml data/fabrics/cell.toml
"""

import argparse
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

sys.path.insert(0, str(Path(__file__).resolve().parent))
from trame import laboratory

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("out", type=Path, help="folder for the runs and the page")
parser.add_argument("fabrics", type=Path, nargs="+", help="scenes with a [weave]")
parser.add_argument("--increments", type=int, default=10, help="of a way [10]")
parser.add_argument("--threads", type=int)
parser.add_argument("--tests", metavar="NAME", nargs="+", help='only these, such as biaxial shear "pull-out"')
parser.add_argument("--without", metavar="NAME", nargs="+", default=[], help="all but these")
options = parser.parse_args()
unknown = {*(options.tests or []), *options.without} - set(laboratory.names)
if unknown:
    parser.error(f"there is no test {', '.join(sorted(unknown))}; must be of {', '.join(laboratory.names)}")
wanted = [name for name in options.tests or laboratory.names if name not in options.without]
options.out.mkdir(parents=True, exist_ok=True)
tests = [test for fabric in options.fabrics
         for test in laboratory.run_tests(fabric, options.out, options.increments, options.threads, wanted)]
if not tests:
    sys.exit("none of these tests is one of these fabrics: cells are sheared, patches have yarns with ends")
figure = plt.figure()
laboratory.page(tests, figure)
for ending in ("png", "svg"):
    figure.savefig(options.out / f"laboratory.{ending}", dpi=110)
print("| fabric | test | at the turn | | loop / work | energy off | bodies off |\n|---|---|---|---|---|---|---|")
for test in tests:
    turn = test.turn
    what = {name: value for name, (value, _, _) in test.must_hold.items()}
    print(f"| {test.fabric} | {test.name} | {test.motion[turn]:.3g} {test.motion_label.rsplit('(')[1][:-1]} "
          f"| {test.force[turn]:.4g} {test.force_label.rsplit('(')[1][:-1]} | {test.loop:.1%} "
          f"| {what['imbalance of energy over what was turned over']:.1%} "
          f"| {what['forces of all bodies over the largest']:.1e} |")
failures = [failure for test in tests for failure in test.failures()]
sys.exit("\n".join(failures) or None)
