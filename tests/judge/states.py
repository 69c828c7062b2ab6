"""Saved states (layout: micro/states/README.md) as curves, contacts and bodies. Needs h5py and numpy."""

import fnmatch
import tomllib

import h5py
import numpy as np


# What the program weaves by where a scene with a weave names no stages, as far as it matters here.
CHOSEN_STAGES = [
    {"name": "separate", "separate_yarns": True, "friction": False, "fiber_model": "rod"},
    {"name": "relax", "fiber_model": "rod"},
    {"name": "settle"},
]


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


class Mesh:
    """What does not change from state to state."""

    def __init__(self, file):
        mesh = file["mesh"]
        self.first = mesh["first_node"][:].astype(int)
        self.radius = mesh["radius"][:]
        self.axial_stiffness = mesh["axial_stiffness"][:]
        self.arc = mesh["arc_length"][:]
        self.yarn = mesh["yarn_of_fiber"][:].astype(int)
        self.yarn_names = [text(x) for x in file["yarns/name"][:]]
        self.yarn_family = file["yarns/family"][:].astype(int)
        self.n_fibers = len(self.radius)
        self.body_names = [text(x) for x in file["bodies/name"][:]] if "bodies" in file else []
        self.scene = tomllib.loads(text(file["scene/text"][0]))
        chosen = CHOSEN_STAGES if "weave" in self.scene else []
        self.stages = {s["name"]: s for s in self.scene.get("stage", chosen)}
        # Of each yarn, its number within its family.
        self.number = [self.yarn_family[:y].tolist().count(k) for y, k in enumerate(self.yarn_family)]

    def is_judged(self, fiber, s):
        """Whether places of a fiber are to be judged, not only there for others to touch."""
        return np.ones(np.shape(s), bool)

    def nodes(self, fiber):
        return slice(self.first[fiber], self.first[fiber + 1])

    def length(self, fiber):
        return self.arc[self.first[fiber + 1] - 1]

    def element_length(self, fiber):
        return self.length(fiber) / ((self.first[fiber + 1] - self.first[fiber] - 1) // 2)

    def fiber_table(self, fiber):
        """The table of the scene that made a fiber, and its fiber type's name."""
        yarn, scene = self.yarn[fiber], self.scene
        name, family = self.yarn_names[yarn], self.yarn_family[yarn]
        if family < 2:
            table = scene["weave"][("warp", "weft")[family]]
            if "order" in table:
                kinds = table["order"].split()
                table = scene["yarn"][kinds[self.number[yarn] % len(kinds)]]
        else:
            table = next(t for t in scene.get("fiber", []) + scene.get("bundle", []) if t["name"] == name)
        return table, table["fiber_type"]


class State:
    """One saved state."""

    def __init__(self, file, increment, mesh):
        self.mesh = mesh
        self.stage = text(file["stage"][increment])
        self.time = float(file["stage_time"][increment])
        fibers = file["fibers"]
        self.r, self.g1, self.g2, self.t = (fibers[k][increment] for k in ("r", "g1", "g2", "tangent"))
        self.proximal = float(file["solver/proximal"][increment])
        self.body_position, self.body_force, self.body_moment = (
            (file["bodies"][k][increment] if "bodies" in file else np.zeros((0, 3)))
            for k in ("position", "force", "moment")
        )
        first, count = (int(file["contacts"][k][increment]) for k in ("first", "count"))
        take = lambda name: file["contacts"][name][first : first + count]
        self.a, self.b = take("fiber_a").astype(int), take("fiber_b").astype(int)
        self.s_a, self.s_b = take("s_a"), take("s_b")
        self.normal, self.friction = (
            take(k).astype(float).reshape(-1, 3) for k in ("normal", "friction_force")
        )
        self.normal_force, self.gap = take("normal_force").astype(float), take("gap").astype(float)
        self.position = take("position").astype(float).reshape(-1, 3)
        self.stands_for = take("length")
        # Of a periodic cell: fiber b is displaced by so many periods.
        image = [take(f"image_{k}") if f"image_{k}" in file["contacts"] else 0 * self.a for k in ("warp", "weft")]
        self.image = np.stack(image, 1).astype(int)
        self.settings = mesh.stages.get(self.stage, {})
        self.is_rod = np.array([self._model(f) == "rod" for f in range(mesh.n_fibers)])

    def _model(self, fiber):
        if "fiber_model" in self.settings:
            return self.settings["fiber_model"]
        return self.mesh.scene["fiber_type"][self.mesh.fiber_table(fiber)[1]].get("model", "enriched")

    def locate(self, fiber, s):
        """Element and local coordinate -1 ... 1 of arc lengths."""
        h = self.mesh.element_length(fiber)
        n = (self.mesh.first[fiber + 1] - self.mesh.first[fiber] - 1) // 2
        e = np.clip((np.asarray(s) / h).astype(int), 0, n - 1)
        return e, np.clip(2 * (s - e * h) / h - 1, -1, 1)

    def stretch(self, fiber, s):
        """Node before arc lengths, of beams, and local coordinate -1 ... 1 to the next one."""
        spacing = self.mesh.element_length(fiber) / 2
        n = self.mesh.first[fiber + 1] - self.mesh.first[fiber]
        k = np.clip((np.asarray(s) / spacing).astype(int), 0, n - 2)
        return k, np.clip(2 * (s - k * spacing) / spacing - 1, -1, 1)

    def curve(self, fiber, s, derivatives=0):
        """r(s), and r', r'' on demand: cubic Hermite, for rods between elements' ends, for beams between all nodes
        with the slopes of the parabolas through neighbours."""
        h = self.mesh.element_length(fiber)
        e, t = self.locate(fiber, s)
        at = self.mesh.nodes(fiber)
        r, d = self.r[at], self.t[at]
        t = t[..., None]
        if self.is_rod[fiber]:
            w = value_hermite(t, h)
            q = (r[2 * e], d[2 * e], r[2 * e + 2], d[2 * e + 2])
        else:
            k, t = self.stretch(fiber, s)
            w = value_hermite(t[..., None], h / 2)
            slope = node_slopes(len(r), h / 2) @ r
            q = (r[k], slope[k], r[k + 1], slope[k + 1])
        out = [sum(c * x for c, x in zip(w[k], q)) for k in range(derivatives + 1)]
        return out[0] if derivatives == 0 else out

    def sections(self, fiber, s):
        """g1(s), g2(s), parabolas."""
        e, t = self.locate(fiber, s)
        at = self.mesh.nodes(fiber)
        w = value_lagrange(t[..., None], 1.0)[0]
        return [sum(c * g[at][2 * e + k] for k, c in enumerate(w)) for g in (self.g1, self.g2)]

    def reach(self, fiber, s, n):
        """How far the section's outline reaches along unit vectors n."""
        if self.is_rod[fiber]:
            return np.full(len(s), self.mesh.radius[fiber])
        g1, g2 = self.sections(fiber, s)
        return self.mesh.radius[fiber] * np.hypot((n * g1).sum(-1), (n * g2).sum(-1))


def node_slopes(n, spacing):
    """Matrix from n values to their slopes: of the parabola through each and its neighbours, at ends the next
    ones."""
    slopes = np.zeros((n, n))
    for i in range(n):
        j = min(max(i - 1, 0), n - 3)
        slopes[i, j : j + 3] = {0: (-1.5, 2, -0.5), 1: (-0.5, 0, 0.5), 2: (0.5, -2, 1.5)}[i - j]
    return slopes / spacing


def value_lagrange(t, h):
    """Parabolas through the nodes -1, 0, 1, and their first two derivatives by arc length."""
    d = 2 / h
    return (
        [t * (t - 1) / 2, 1 - t * t, t * (t + 1) / 2],
        [(t - 0.5) * d, -2 * t * d, (t + 0.5) * d],
        [d * d + 0 * t, -2 * d * d + 0 * t, d * d + 0 * t],
    )


def value_hermite(t, h):
    """Cubic Hermite functions of (r, r', r, r'), and their first two derivatives by arc length."""
    u = (t + 1) / 2
    return (
        [
            1 - 3 * u**2 + 2 * u**3,
            h * (u - 2 * u**2 + u**3),
            3 * u**2 - 2 * u**3,
            h * (u**3 - u**2),
        ],
        [(6 * u**2 - 6 * u) / h, 1 - 4 * u + 3 * u**2, (6 * u - 6 * u**2) / h, 3 * u**2 - 2 * u],
        [(12 * u - 6) / h**2, (6 * u - 4) / h, (6 - 12 * u) / h**2, (6 * u - 2) / h],
    )


def ties(mesh):
    """(fiber, end, body) of every tied end."""
    out = []
    for body in mesh.scene.get("body", []):
        for tie in body.get("tie", []):
            for f in range(mesh.n_fibers):
                if fnmatch.fnmatchcase(mesh.yarn_names[mesh.yarn[f]], tie["fibers"]):
                    out.append((f, tie["end"], mesh.body_names.index(body["name"])))
    for f in range(mesh.n_fibers):
        if mesh.yarn_family[mesh.yarn[f]] < 2 and f"{mesh.yarn_names[mesh.yarn[f]]}/start" in mesh.body_names:
            for end in ("start", "end"):
                out.append((f, end, mesh.body_names.index(f"{mesh.yarn_names[mesh.yarn[f]]}/{end}")))
    return out


def followers(mesh, state):
    """(follower, leader) pairs of bodies in the state's stage."""
    out = []
    for drive in state.settings.get("drive", []):
        if "follow" in drive:
            wanted = drive["bodies"] if isinstance(drive["bodies"], list) else [drive["bodies"]]
            leader = mesh.body_names.index(drive["follow"])
            out += [
                (b, leader)
                for b, name in enumerate(mesh.body_names)
                if any(fnmatch.fnmatchcase(name, w) for w in wanted)
            ]
    return out


def groups(mesh, state):
    """Fibers that bodies hold together, with their bodies."""
    parent = list(range(mesh.n_fibers + len(mesh.body_names)))

    def root(x):
        while parent[x] != x:
            parent[x] = parent[parent[x]]
            x = parent[x]
        return x

    for fiber, _, body in ties(mesh):
        parent[root(fiber)] = root(mesh.n_fibers + body)
    out = {}
    for f in range(mesh.n_fibers):
        out.setdefault(root(f), ([], []))[0].append(f)
    for b in range(len(mesh.body_names)):
        if root(mesh.n_fibers + b) in out:
            out[root(mesh.n_fibers + b)][1].append(b)
    return list(out.values())
