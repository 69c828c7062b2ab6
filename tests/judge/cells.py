"""A periodic cell laid out: each fiber over three periods of its own, between copies of its neighbours, so
that what is true of any patch can be asked of its middle."""

import numpy as np

from states import Mesh, State

PERIODS = ("cell/warp", "cell/weft")
COPIES = (-1, 0, 1)


def is_cell(mesh):
    return any(name in mesh.body_names for name in PERIODS)


def periods_of(mesh, state):
    """Both period vectors; none where the weave has ends along it."""
    names = mesh.body_names
    return [state.body_position[names.index(p)] if p in names else None for p in PERIODS]


class Layout:
    """Which copies of which fibers there are, and which stretch of them is judged."""

    def __init__(self, mesh):
        self.mesh = mesh
        self.goes_on = [name in mesh.body_names for name in PERIODS]
        family = mesh.yarn_family[mesh.yarn]
        # The period along which a fiber comes back to itself, or -1.
        self.own = np.array([k if k < 2 and self.goes_on[k] else -1 for k in family])
        self.copies, self.index = [], {}
        for f in range(mesh.n_fibers):
            for move in self.moves(but_along=self.own[f]):
                self.index[f, move] = len(self.copies)
                self.copies.append((f, move))

    def moves(self, but_along=-1):
        """Displacements of copies, in periods, none along one of them."""
        along = [COPIES if self.goes_on[k] and k != but_along else (0,) for k in (0, 1)]
        return [(i, j) for i in along[0] for j in along[1]]

    def place(self, fiber, s, move):
        """The copy of a fiber that is displaced by `move`, and the arc length there; None beyond what is laid
        out."""
        own = self.own[fiber]
        if own < 0:
            found = self.index.get((fiber, tuple(move)))
            return None if found is None else (found, s)
        across = list(move)
        across[own] = 0
        found = self.index.get((fiber, tuple(across)))
        s = s + (move[own] + 1) * self.mesh.length(fiber)
        inside = 0 <= s <= 3 * self.mesh.length(fiber)
        return (found, s) if found is not None and inside else None

    def nodes(self, values, fiber, shift=None):
        """Values at a fiber's nodes over its three periods, `shift` being what each adds."""
        own = values[self.mesh.nodes(fiber)]
        if self.own[fiber] < 0:
            return own
        step = np.zeros(own.shape[1:]) if shift is None else shift
        return np.concatenate([own[:-1] - step, own[:-1], own + step])


class LaidOutMesh(Mesh):
    def __init__(self, layout):
        mesh, copies = layout.mesh, layout.copies
        of = np.array([f for f, _ in copies])
        n_yarns = len(mesh.yarn_names)
        # Copies of a yarn are other yarns.
        moves = sorted({move for _, move in copies})
        self.yarn = np.array([mesh.yarn[f] + n_yarns * moves.index(move) for f, move in copies])
        self.yarn_names = list(mesh.yarn_names) * len(moves)
        self.yarn_family = np.tile(mesh.yarn_family, len(moves))
        self.number = list(mesh.number) * len(moves)
        self.radius, self.axial_stiffness = mesh.radius[of], mesh.axial_stiffness[of]
        self.n_fibers, self.body_names, self.scene, self.stages = len(of), [], mesh.scene, mesh.stages
        arcs = [layout.nodes(mesh.arc, f, mesh.length(f)) for f in of]
        arcs = [a - a[0] for a in arcs]
        self.arc = np.concatenate(arcs)
        self.first = np.concatenate([[0], np.cumsum([len(a) for a in arcs])])
        self.in_middle = np.array([move == (0, 0) for _, move in copies])
        self.one_period = [(mesh.length(f), 2 * mesh.length(f)) if layout.own[f] >= 0 else None for f in of]

    def is_judged(self, fiber, s):
        if not self.in_middle[fiber]:
            return np.zeros(np.shape(s), bool)
        bounds = self.one_period[fiber]
        return np.ones(np.shape(s), bool) if bounds is None else (s >= bounds[0]) & (s < bounds[1])


class LaidOutState(State):
    def __init__(self, state, layout, mesh):
        self.mesh = mesh
        for name in ("stage", "time", "proximal", "settings"):
            setattr(self, name, getattr(state, name))
        periods = [np.zeros(3) if p is None else p for p in periods_of(layout.mesh, state)]
        displaced = lambda move: move[0] * periods[0] + move[1] * periods[1]
        own = lambda f: periods[layout.own[f]] if layout.own[f] >= 0 else None
        self.r = np.concatenate([layout.nodes(state.r, f, own(f)) + displaced(m) for f, m in layout.copies])
        for name in ("g1", "g2", "t"):
            values = getattr(state, name)
            setattr(self, name, np.concatenate([layout.nodes(values, f) for f, _ in layout.copies]))
        self.is_rod = np.array([state.is_rod[f] for f, _ in layout.copies])
        rows, ends = [], []
        for k in range(len(state.a)):
            for move in layout.moves():
                at_a = layout.place(state.a[k], state.s_a[k], move)
                at_b = layout.place(state.b[k], state.s_b[k], tuple(np.add(move, state.image[k])))
                if at_a and at_b:
                    rows.append(k)
                    ends.append((*at_a, *at_b, *displaced(move)))
        ends = np.array(ends).reshape(-1, 7)
        self.a, self.b = ends[:, 0].astype(int), ends[:, 2].astype(int)
        self.s_a, self.s_b = ends[:, 1], ends[:, 3]
        self.position = state.position[rows] + ends[:, 4:]
        for name in ("normal", "friction", "normal_force", "gap", "stands_for"):
            setattr(self, name, getattr(state, name)[rows])


def laid_out(mesh, states):
    """The mesh and some of its states, laid out."""
    layout = Layout(mesh)
    wide = LaidOutMesh(layout)
    return wide, [LaidOutState(s, layout, wide) for s in states]
