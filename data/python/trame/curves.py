"""curves.csv and branches.csv: what is driven, with units."""

import re
from dataclasses import dataclass

import pandas as pd

Table = pd.DataFrame

_unit_of_suffix = {"m": "m", "rad": "rad", "N": "N", "Nm": "N m"}
_of_test = re.compile(r"(.*)\.(motion|reaction)_(.*)", re.DOTALL)  # the curve that a [test] is done for


def unit(column):
    """Of a column of curves.csv: "m" for "right.x_m", "1" for "warp_strain", "" for the name of a stage."""
    if column == "stage":
        return ""
    if column == "stage_time" or column.endswith("_strain"):
        return "1"
    if test := _of_test.fullmatch(column):
        return _unit_of_suffix.get(test[3], test[3])
    return _unit_of_suffix.get(column.rsplit("_", 1)[-1], "")


def read_table(file):
    """A table of ours as pandas has it, with the units of its columns in attrs["units"]."""
    table = pd.read_csv(file)
    table.attrs["units"] = {column: unit(column) for column in table.columns}
    return table


@dataclass
class Curve:
    """A reaction over a motion, with its units."""

    name: str
    table: Table  # stage, stage_time, motion, reaction
    motion_unit: str
    reaction_unit: str

    def stage(self, name):
        """The part of one stage."""
        part = self.table[self.table["stage"] == name].reset_index(drop=True)
        if part.empty:
            raise KeyError(f"stage {name}: must be one of {', '.join(self.table['stage'].unique())}")
        return Curve(self.name, part, self.motion_unit, self.reaction_unit)


def curves_of(table, widths=None):
    """The curves of a table of curves.csv by name. `widths`: of the fabric across warp and weft (m); sides are forces per
    width then."""
    curves = {}

    def add(name, motion, reaction, motion_unit, reaction_unit, per=1.0):
        part = table[["stage", "stage_time"]].copy()
        part["motion"] = table[motion]
        part["reaction"] = table[reaction] / per
        curves[name] = Curve(name, part, motion_unit, reaction_unit)

    for side, width in zip(("warp", "weft"), widths or (None, None)):
        if f"{side}_strain" in table:
            add(f"{side} sides", f"{side}_strain", f"{side}_force_N", "1", "N/m" if width else "N", width or 1.0)
    tests = {found[1]: column for column in table.columns if (found := _of_test.fullmatch(column))}
    for name, reaction in tests.items():
        motion = next(column for column in table.columns if column.startswith(f"{name}.motion_"))
        add(name, motion, reaction, unit(motion), unit(reaction))
    for column in table.columns:
        found = re.fullmatch(r"(.*)\.(r?[xyz])_(m|rad)", column, re.DOTALL)
        if not found:
            continue
        body, dof, motion_unit = found.groups()
        reaction = f"{body}.{dof}_" + ("N" if motion_unit == "m" else "Nm")
        if reaction in table:
            add(f"{body}, {dof}", column, reaction, motion_unit, unit(reaction))
    return curves
