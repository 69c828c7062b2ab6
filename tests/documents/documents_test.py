#!/usr/bin/python3
"""Do the documents agree with the files that they tell of? Prints every fault, and exits with 1 if there is one.

    documents_test.py [ROOT]

- Every relative link of a .md file leads to a file or folder, and its #part to a heading.
- Every source file under micro/, meso/ and workflows/ is named in the README of its folder, or of one above it up to
  the module. A file is named by its stem in backquotes, with or without folders before it and ending after it:
  `newton`, `solve/newton`, `newton.h`. One entry does for .h and .cpp. `curves_*` names all stems that begin so.
- What stands in backquotes in the columns of a table of files (its head has a cell with "file", and ends in "what") but
  the last is there: beside the README, or where it has no folder, anywhere under it. In the last column, and in all
  other text, so is what begins with a folder of the repository.
- Lines have at most 110 characters, but for tables, commands that go on with a backslash, and what has no blank to
  break at. READMEs of modules have at most 150 lines.
- Words that have another name in this field are not used.
"""

import os
import pathlib
import re
import sys

MODULES = ("micro", "meso", "workflows")
FOLDERS = (*MODULES, "tests", "data")
LONGEST_LINE = 110
MOST_LINES = 150
OTHER_WORDS = {
    "objection": "inadmissibility",
    "announc": "tells, says",
    "allowance": "limit, tolerance",
    "forgiv": "lets be",
}

ROOT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent.parent).resolve()
faults = []


def fault(path, line, text):
    faults.append(f"{path.relative_to(ROOT)}:{line}: {text}")


def files(ending, below=ROOT):
    for folder, folders, names in os.walk(below):
        folders[:] = sorted(f for f in folders if not f.startswith(".") and f not in ("build", "results"))
        yield from (pathlib.Path(folder) / name for name in sorted(names) if name.endswith(ending))


class Document:
    def __init__(self, path):
        self.path = path
        self.lines = path.read_text(encoding="utf-8").rstrip("\n").split("\n")
        self.fenced = []  # whether a line belongs to a block of code
        inside = False
        for line in self.lines:
            fence = line.lstrip().startswith("```")
            self.fenced.append(inside or fence)
            inside ^= fence
        # Text without blocks of code, line by line, for what may go over an end of line.
        self.text = "\n".join("" if fenced else line for line, fenced in zip(self.lines, self.fenced))
        self.names = [
            (" ".join(match[1].split()), self.line_of(match)) for match in re.finditer(r"`([^`]+)`", self.text)
        ]

    def line_of(self, match):
        return self.text.count("\n", 0, match.start()) + 1

    def headings(self):
        titles = [line.lstrip("#").strip().lower() for line in self.text.split("\n") if line.startswith("#")]
        return {re.sub(r"[^\w\- ]", "", title).replace(" ", "-") for title in titles}


def check_links(document):
    without_names = re.sub(r"`[^`]*`", lambda name: re.sub(r"[^\n]", "x", name[0]), document.text)
    for match in re.finditer(r"\]\(([^()\s]+)\)", without_names):
        target, _, part = match[1].partition("#")
        if re.match(r"[a-z]+:", target):
            continue
        path = document.path.parent / target if target else document.path
        if not path.exists():
            fault(document.path, document.line_of(match), f"link to {match[1]}, which is not there")
        elif part and path.suffix == ".md" and part not in Document(path).headings():
            fault(document.path, document.line_of(match), f"link to {match[1]}, a heading that is not there")


def names_stem(name, stem):
    name = re.sub(r"\.(h|cpp)$", "", name.rpartition("/")[2])
    return name == stem or (name.endswith("*") and len(name) > 1 and stem.startswith(name[:-1]))


def check_sources(documents):
    for module in MODULES:
        for path in files((".h", ".cpp"), ROOT / module):
            if path.suffix == ".cpp" and path.with_suffix(".h").exists():
                continue
            above = path.parent
            named = False
            while above != ROOT:
                if readme := documents.get(above / "README.md"):
                    named |= any(names_stem(name, path.stem) for name, _ in readme.names)
                above = above.parent
            if not named:
                fault(path, 1, "no README of its folder or of one above it names it")


def is_there(folder, name):
    """`name` as a path from `folder`, with or without its ending, with wildcards or without."""
    name = name.strip("/")
    return bool(name) and any(any(folder.glob(name + ending)) for ending in ("", ".h", ".cpp", ".py"))


def check_tables(document):
    columns = None  # of a table of files
    for number, line in enumerate(document.lines, 1):
        if not line.startswith("|") or document.fenced[number - 1]:
            columns = None
            continue
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if columns is None:
            is_of_files = cells[-1] == "what" and any("file" in re.findall(r"\w+", cell) for cell in cells)
            columns = len(cells) if is_of_files else 0
            continue
        for cell in cells[: columns - 1] if columns else []:
            for name in re.findall(r"`([^`]+)`", cell):
                here = document.path.parent
                if not is_there(here, name) and ("/" in name.rstrip("/") or not is_there(here, f"**/{name}")):
                    fault(document.path, number, f"a table of files names {name}, which is not there")


def check_paths(document):
    for name, number in document.names:
        if re.fullmatch(rf"({'|'.join(FOLDERS)}|\.\.)/[\w./*+-]+", name):
            if not is_there(ROOT, name) and not is_there(document.path.parent, name):
                fault(document.path, number, f"{name} is not there")


def check_lengths(document):
    for number, (line, fenced) in enumerate(zip(document.lines, document.fenced), 1):
        goes_on = fenced and line.endswith("\\")
        unbroken = re.fullmatch(r"\s*([-*] |\d+\. )?\S+", line)
        if len(line) > LONGEST_LINE and not line.startswith("|") and not goes_on and not unbroken:
            fault(document.path, number, f"{len(line)} characters, more than {LONGEST_LINE}")
    of_module = document.path.relative_to(ROOT).parts[0] in MODULES
    if of_module and len(document.lines) > MOST_LINES:
        fault(document.path, len(document.lines), f"{len(document.lines)} lines, more than {MOST_LINES}")


def check_words(document):
    for number, line in enumerate(document.lines, 1):
        for word, better in OTHER_WORDS.items():
            if re.search(rf"\b{word}", line, re.IGNORECASE):
                fault(document.path, number, f"'{word}…': here it is called {better}")


def main():
    documents = {path: Document(path) for path in files(".md")}
    for module in MODULES:
        if ROOT / module / "README.md" not in documents:
            fault(ROOT / module / "README.md", 1, "is not there")
    for document in documents.values():
        for check in (check_links, check_tables, check_paths, check_lengths, check_words):
            check(document)
    check_sources(documents)
    print("\n".join(faults) or f"{len(documents)} documents are in order")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
