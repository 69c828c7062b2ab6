"""Scenes as dictionaries: to TOML, with changes, and lengths read from them."""

import copy
import json
import math
import re

_plain_key = re.compile(r"[A-Za-z0-9_-]+")


def _key(name):
    return name if _plain_key.fullmatch(name) else json.dumps(name, ensure_ascii=False)


def _value(value, where):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
    if hasattr(value, "item"):  # of numpy
        value = value.item()
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(entry, where) for entry in value) + "]"
    raise TypeError(f"{where}: {type(value).__name__} must be a number, a text, a truth value, a list or a dict of them")


def _is_tables(value):
    return isinstance(value, (list, tuple)) and len(value) > 0 and all(isinstance(entry, dict) for entry in value)


def scene_text(scene, path=()):
    """The TOML of a scene that is a dict of what TOML holds: tables are dicts, arrays of tables lists of dicts."""
    lines, tables = [], []
    for name, value in scene.items():
        where = ".".join([*path, name])
        if isinstance(value, dict):
            header = ".".join(_key(part) for part in (*path, name))
            tables.append(f"\n[{header}]\n" + scene_text(value, (*path, name)))
        elif _is_tables(value):
            header = ".".join(_key(part) for part in (*path, name))
            tables.extend(f"\n[[{header}]]\n" + scene_text(entry, (*path, name)) for entry in value)
        else:
            lines.append(f"{_key(name)} = {_value(value, where)}\n")
    return "".join(lines) + "".join(tables)


def changed(scene, changes):
    """A copy of a scene with some keys changed. A key is a path of names and, into lists, numbers or the `name` of an
    entry: "contact.friction_coefficient", "stage.load.increments"."""
    result = copy.deepcopy(scene)
    for path, value in changes.items():
        at, names = result, path.split(".")
        for name in names[:-1]:
            at = _entry(at, name, path)
        if isinstance(at, list):
            at[_index(at, names[-1], path)] = value
        else:
            at[names[-1]] = value
    return result


def _index(entries, name, path):
    named = [i for i, entry in enumerate(entries) if isinstance(entry, dict) and entry.get("name") == name]
    if len(named) == 1:
        return named[0]
    if name.isdigit() and int(name) < len(entries):
        return int(name)
    raise KeyError(f"{path}: there is no entry {name}; must be a name of one, or a number below {len(entries)}")


def _entry(at, name, path):
    if isinstance(at, list):
        return at[_index(at, name, path)]
    if not isinstance(at, dict) or not isinstance(at.setdefault(name, {}), (dict, list)):
        raise KeyError(f"{path}: {name} is no table")
    return at[name]


_metres = {"in": 0.0254, "inch": 0.0254, "m": 1.0, "dm": 1e-1, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "nm": 1e-9}


def length_of(value):
    """A length of a scene in m: "130 um"."""
    number, _, unit = str(value).strip().partition(" ")
    if unit.strip() not in _metres:
        raise ValueError(f"{value}: must be a number and a unit of {', '.join(_metres)}")
    return float(number) * _metres[unit.strip()]


def angle_of(value):
    """Of a text such as "60 deg", rad."""
    number, _, unit = value.strip().partition(" ")
    radians = {"rad": 1, "deg": math.pi / 180}
    if unit.strip() not in radians:
        raise ValueError(f"{value}: must be a number and a unit of {', '.join(radians)}")
    return float(number) * radians[unit.strip()]


def spacing_of(system):
    """Of the yarns of [weave.warp] or [weave.weft], m: from its yarn_spacing or its sett, "50 per cm"."""
    if "yarn_spacing" in system:
        return length_of(system["yarn_spacing"])
    number, _, unit = str(system["sett"]).strip().partition(" ")
    unit = unit.replace("per", "").replace("/", "").strip().removesuffix("-1")
    return length_of(f"1 {unit}") / float(number)
