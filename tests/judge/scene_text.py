"""Scenes written as TOML. Lengths in the unit of the scene's own choice, R of a typical fiber by default 10
um."""

import math


def number(x):
    return f"{x:.12g}"


class Scene:
    """Collects tables; `text()` writes them. All lengths in um, moduli in Pa, forces in N, moments in N m,
    angles in rad."""

    def __init__(self, title):
        self.title, self.parts, self.effects, self.contact, self.solver, self.stages = (
            title,
            [],
            {},
            {},
            {},
            [],
        )
        self.bodies = {}
        self.stage_names = 0

    def material(self, name, modulus, nu):
        self.parts.append(
            f'[material.{name}]\nmodel = "isotropic"\nyoung_modulus = "{number(modulus)} Pa"\n'
            f"poisson_ratio = {number(nu)}"
        )

    def aligned_material(self, name, axial, transverse, shear, nu, nu_t):
        self.parts.append(
            f'[material.{name}]\nmodel = "transversely_isotropic"\n'
            f'young_modulus_axial = "{number(axial)} Pa"\n'
            f'young_modulus_transverse = "{number(transverse)} Pa"\n'
            f'shear_modulus_axial = "{number(shear)} Pa"\n'
            f"poisson_ratio_axial = {number(nu)}\npoisson_ratio_transverse = {number(nu_t)}"
        )

    def fiber_type(self, name, material, radius, model):
        self.parts.append(
            f'[fiber_type.{name}]\nmaterial = "{material}"\ndiameter = "{number(2 * radius)} um"\n'
            f'model = "{model}"'
        )

    @staticmethod
    def point(p):
        return "[" + ", ".join(f'"{number(x)} um"' for x in p) + "]"

    def fiber(self, name, kind, points, elements):
        points = ",\n  ".join(self.point(p) for p in points)
        self.parts.append(
            f'[[fiber]]\nname = "{name}"\nfiber_type = "{kind}"\n'
            f"elements = {elements}\npoints = [\n  {points}]"
        )

    def bundle(self, name, kind, points, elements, fibers, spacing=1.05, twist=0.0):
        points = ", ".join(self.point(p) for p in points)
        self.parts.append(
            f'[[bundle]]\nname = "{name}"\nfiber_type = "{kind}"\n'
            f"elements = {elements}\npoints = [{points}]\n"
            f"fibers = {fibers}\nlattice_spacing = {number(spacing)}\ntwist = {number(twist)}"
        )

    def raw(self, text):
        self.parts.append(text)

    def body(self, name, position, ties):
        """`ties`: (fibers, end) or (fibers, end, kind)."""
        text = f'[[body]]\nname = "{name}"\nposition = {self.point(position)}'
        for fibers, end, *kind in ties:
            text += f'\n[[body.tie]]\nfibers = "{fibers}"\nend = "{end}"'
            text += f'\nkind = "{kind[0]}"' if kind else ""
        self.parts.append(text)

    def stage(self, name, increments, drives, **keys):
        """`drives`: (bodies, dof, kind, value) with kind displacement (um or rad) or force (N or N m)."""
        text = f'[[stage]]\nname = "{name}"\nincrements = {increments}'
        for key, value in keys.items():
            text += f"\n{key} = {toml(value)}"
        for bodies, dof, kind, value in drives:
            if kind == "follow":
                shown = f'"{value}"'
            elif kind == "strain":
                shown = number(value)
            elif kind == "force":
                shown = f'"{number(value)} {"N" if len(dof) == 1 else "N m"}"'
            else:
                shown = f'"{number(value)} {"um" if len(dof) == 1 else "rad"}"'
            text += f'\n[[stage.drive]]\nbodies = "{bodies}"\ndof = "{dof}"\n{kind} = {shown}'
        self.stages.append(text)

    def text(self):
        out = [f'title = "{self.title}"'] + self.parts
        for name in ("effects", "contact", "solver"):
            table = getattr(self, name)
            if table:
                out.append(f"[{name}]\n" + "\n".join(f"{k} = {toml(v)}" for k, v in table.items()))
        return "\n\n".join(out + self.stages) + "\n"


def toml(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    return f'"{value}"' if isinstance(value, str) else number(value)


def helix(radius, turns, phase, length, n_per_turn=16, origin=(0, 0, 0)):
    """Points of a helix around x."""
    n = max(8, math.ceil(abs(turns) * n_per_turn))
    return [
        (
            origin[0] + length * i / n,
            origin[1] + radius * math.cos(phase + 2 * math.pi * turns * i / n),
            origin[2] + radius * math.sin(phase + 2 * math.pi * turns * i / n),
        )
        for i in range(n + 1)
    ]
