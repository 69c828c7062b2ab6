"""A run: its folder as results stand in it, or its state file alone."""

import json
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path

import h5py
import numpy as np
import pandas as pd

from .curves import curves_of, read_table
from .scene import angle_of, spacing_of

families = ("warp", "weft", "free")


@dataclass
class Fiber:
    """A fiber in a state; rows are its nodes."""

    index: int
    radius: float  # m
    arc_length: np.ndarray  # s, m, in the reference state
    r: np.ndarray  # centre line, m
    tangent: np.ndarray  # dr/ds
    g1: np.ndarray  # section vectors
    g2: np.ndarray
    copy: tuple[int, int] = (0, 0)  # of a periodic cell: displaced by so many periods


def open_run(path):
    """`path`: a folder with results, or a state file. The run may still be going on."""
    return Run(path)


class Run:
    def __init__(self, path):
        path = Path(path)
        self.folder = path if path.is_dir() else path.parent
        self.states_file = path / "states.h5" if path.is_dir() else path
        if not self.states_file.is_file():
            raise FileNotFoundError(f"{self.states_file}: there are no states of a run")
        try:
            self._file = h5py.File(self.states_file, "r")
        except OSError:  # its writer is at work, or was killed
            self._file = h5py.File(self.states_file, "r", swmr=True)
        if self._attribute("layout") != "trame-states":
            self._file.close()
            raise ValueError(f"{self.states_file}: not the states of a run")
        self.scene_text = self._texts("scene/text")[0]
        self.name = self._texts("scene/name")[0]
        self.yarn_names = self._texts("yarns/name")
        self.body_names = self._texts("bodies/name")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self._file.close()

    def _attribute(self, name):
        value = self._file.attrs.get(name, "")
        return value.decode() if isinstance(value, bytes) else value

    def _texts(self, path):
        return [text.decode(errors="replace") for text in self._file[path][()]]

    # ---- the whole run

    @property
    def n_states(self):
        """Saved states; state 0 is the reference."""
        return int(self._file["n_increments"][()])

    def scene(self):
        """The scene as a dict, to change and run again."""
        return tomllib.loads(self.scene_text)

    def summary(self):
        """summary.json."""
        return json.loads((self.folder / "summary.json").read_text())

    def states(self):
        """A line for each saved state: stage, time within it, contacts, energies (J), the solver's work."""
        n = self.n_states
        table = {"stage": [self._stage(i) for i in range(n)], "stage_time": self._file["stage_time"][:n],
                 "contacts": self._file["contacts/count"][:n]}
        for group in ("energy", "solver", "sides"):
            for name, values in self._file.get(group, {}).items():
                table[name if group != "sides" else f"side_{name}"] = values[:n]
        result = pd.DataFrame(table)
        result.attrs["units"] = {"stage_time": "1", "contacts": "1"}
        for group in ("energy", "solver", "sides"):
            for name, values in self._file.get(group, {}).items():
                unit = values.attrs.get("unit", "")
                key = name if group != "sides" else f"side_{name}"
                result.attrs["units"][key] = unit.decode() if isinstance(unit, bytes) else unit
        return result

    def curves(self):
        """curves.csv: every increment, and the start of every stage; motions and reactions of all that is driven."""
        return read_table(self.folder / "curves.csv")

    def branches(self):
        """branches.csv: loading and unloading apart, with stiffness, work and loops."""
        return read_table(self.folder / "branches.csv")

    def widths(self):
        """Of the fabric that warp and weft pull on, m; nothing without a weave."""
        weave = self.scene().get("weave")
        if not weave:
            return None
        warps, columns = weave["warp"]["yarns"], weave["weft"]["yarns"] // weave.get("weft_layers", 1)
        return warps * spacing_of(weave["warp"]), columns * spacing_of(weave["weft"])

    def area(self):
        """Of the fabric on which plates press, m²; nothing without a weave."""
        weave, widths = self.scene().get("weave", {}), self.widths()
        return widths and widths[0] * widths[1] / np.sin(angle_of(weave.get("angle", "90 deg")))

    def curve(self, name):
        """One reaction over its motion, such as "right, x" or "warp sides" (N/m over strain)."""
        curves = curves_of(self.curves(), self.widths())
        if name not in curves:
            raise KeyError(f"{name}: must be one of {'; '.join(curves)}")
        return curves[name]

    # ---- a state

    def state(self, which=-1):
        """The number of a state: itself, counted from the end where negative, or that at the end of the stage named."""
        n = self.n_states
        if isinstance(which, str):
            stages = [self._stage(i) for i in range(n)]
            if which not in stages:
                raise KeyError(f"stage {which}: must be one of {', '.join(dict.fromkeys(stages))}")
            return n - 1 - stages[::-1].index(which)
        number = int(which)
        if not -n <= number < n:
            raise IndexError(f"state {which}: there are {n}, counted from 0")
        return number % n

    def _stage(self, i):
        return self._file["stage"][i].split(b"\0")[0].decode(errors="replace")

    def yarns(self):
        """A line for each yarn: name, family, first fiber, number of fibers."""
        return pd.DataFrame({"name": self.yarn_names, "family": [families[f] for f in self._file["yarns/family"]],
                             "first_fiber": self._file["yarns/first_fiber"][()],
                             "n_fibers": self._file["yarns/n_fibers"][()]})

    def positions(self, state=-1):
        """Of all nodes, m."""
        return self._file["fibers/r"][self.state(state)]

    def fibers(self, yarn=None, state=-1):
        """The fibers of a yarn (its name or number), or all."""
        which = range(self._file["mesh/radius"].shape[0]) if yarn is None else self._fibers_of(yarn)
        i, first = self.state(state), self._file["mesh/first_node"][()]
        arrays = {name: self._file[f"fibers/{name}"][i] for name in ("r", "tangent", "g1", "g2")}
        arc, radius = self._file["mesh/arc_length"][()], self._file["mesh/radius"][()]
        nodes = [slice(first[f], first[f + 1]) for f in which]
        return [Fiber(f, float(radius[f]), arc[n], *(arrays[a][n] for a in ("r", "tangent", "g1", "g2")))
                for f, n in zip(which, nodes)]

    def periods(self, state=-1):
        """Period vectors (m) of a periodic cell along its warp and along its weft; None along yarns that have ends."""
        weave = self.scene().get("weave", {})
        periodic, i = weave.get("periodic", False), self.state(state)
        return tuple(self._file["bodies/position"][i][self.body_names.index(f"cell/{family}")]
                     if periodic is True or periodic == family else None for family in families[:2])

    def copies(self, n=(2, 2), yarn=None, state=-1):
        """The fibers of a yarn, or all, of n[0] times n[1] copies of a periodic cell, along its warp and along its weft:
        copy (i, j) is displaced by i and j periods of that state. (0, 0) is the cell itself, the first of two copies,
        the middle one of three, as in `vtk/fibers.pvd`."""
        periods, fibers = self.periods(state), self.fibers(yarn, state)
        for count, period, family in zip(n, periods, families):
            if count < 1:
                raise ValueError(f"copies {n}: must be 1 or more along both")
            if count > 1 and period is None:
                raise ValueError(f"copies {n}: the weave is not periodic along its {family}")
        vectors = [np.zeros(3) if period is None else period for period in periods]
        return [replace(fiber, r=fiber.r + (i * vectors[0] + j * vectors[1]), copy=(i, j))
                for j in _numbers(n[1]) for i in _numbers(n[0]) for fiber in fibers]

    def _fibers_of(self, yarn):
        if isinstance(yarn, str):
            if yarn not in self.yarn_names:
                raise KeyError(f"yarn {yarn}: must be one of {', '.join(self.yarn_names)}")
            yarn = self.yarn_names.index(yarn)
        first = int(self._file["yarns/first_fiber"][yarn])
        return range(first, first + int(self._file["yarns/n_fibers"][yarn]))

    def bodies(self, state=-1):
        """A line for each body: position (m), force (N) and moment (N m) on it, motion (m) and turn (rad) so far."""
        table, i = {"name": self.body_names}, self.state(state)
        for name in ("position", "force", "moment", "motion", "turn"):
            if self.body_names and f"bodies/{name}" in self._file:
                for d, axis in enumerate("xyz"):
                    table[f"{name}_{axis}"] = self._file[f"bodies/{name}"][i][:, d]
        return pd.DataFrame(table)

    def contacts(self, state=-1):
        """A line for each touch of two fibers: which, their yarns, where, forces (N), gap (m); `pressure` is the normal force per length of fiber over the diameter of the thinner one (Pa)."""
        i = self.state(state)
        first, count = int(self._file["contacts/first"][i]), int(self._file["contacts/count"][i])
        rows = slice(first, first + count)
        table = {}
        for name in ("fiber_a", "fiber_b", "s_a", "s_b", "gap", "normal_force", "length"):
            table[name] = self._file[f"contacts/{name}"][rows]
        for name in ("position", "normal", "friction_force", "slip"):
            values = self._file[f"contacts/{name}"][rows]
            for d, axis in enumerate("xyz"):
                table[f"{name}_{axis}"] = values[:, d]
        result = pd.DataFrame(table)
        yarn, radius = self._file["mesh/yarn_of_fiber"][()], self._file["mesh/radius"][()]
        for end in "ab":
            result[f"yarn_{end}"] = yarn[result[f"fiber_{end}"].to_numpy(dtype=int)]
        thinner = np.minimum(radius[result["fiber_a"].to_numpy(dtype=int)], radius[result["fiber_b"].to_numpy(dtype=int)])
        with np.errstate(divide="ignore", invalid="ignore"):
            pressure = result["normal_force"] / (result["length"] * 2 * thinner)
        result["pressure"] = pressure.where(result["length"] > 0)
        return result

    def cut(self, yarn, at=0.5, state=-1):
        """A section of a yarn by the plane at right angles to it through the point at a share `at` of its middle line:
        a line for each of its fibers, with the place of its axis in the plane (across, up; m) and in space, and its
        radius. Fibers that end before the plane are left out."""
        if not 0 <= at <= 1:
            raise ValueError(f"at = {at}: must be between 0 and 1")
        fibers = self.fibers(yarn, state)
        middle = np.mean([_resampled(fiber.r, 201) for fiber in fibers], axis=0)
        s = at * (len(middle) - 1)
        k = min(int(s), len(middle) - 2)
        point = middle[k] + (s - k) * (middle[k + 1] - middle[k])
        axis = middle[min(k + 2, 200)] - middle[max(k - 1, 0)]
        axis /= np.linalg.norm(axis)
        up = np.array([0, 0, 1.0]) if abs(axis[2]) < 0.9 else np.array([1.0, 0, 0])
        up -= up.dot(axis) * axis
        up /= np.linalg.norm(up)
        across = np.cross(up, axis)
        rows = []
        for fiber in fibers:
            crossing = _crossing(fiber.r, point, axis)
            if crossing is not None:
                offset = crossing - point
                rows.append((fiber.index, offset.dot(across), offset.dot(up), fiber.radius, *crossing))
        return pd.DataFrame(rows, columns=["fiber", "across", "up", "radius", "x", "y", "z"])


def _numbers(count):
    """Of copies along a period: around 0."""
    return range(-((count - 1) // 2), count // 2 + 1)


def _resampled(r, n):
    """Points of a polyline at equal shares of its nodes."""
    at = np.linspace(0, len(r) - 1, n)
    return np.stack([np.interp(at, np.arange(len(r)), r[:, d]) for d in range(3)], axis=1)


def _crossing(r, point, axis):
    """Where a polyline passes a plane, nearest to the plane's point."""
    height = (r - point) @ axis
    steps = np.flatnonzero((height[:-1] <= 0) != (height[1:] <= 0))
    if len(steps) == 0:
        return None
    places = [r[i] + height[i] / (height[i] - height[i + 1]) * (r[i + 1] - r[i]) for i in steps]
    return min(places, key=lambda place: np.linalg.norm(place - point))
