#!/usr/bin/env python3
"""Checks the layers of the workspace: no crate names one above it, no modules of a crate name each other in a circle, no room has more
than a dozen modules, and no file of tests is left out of the test executable of its crate.

A file and those of its own folder are one room: `foo.rs` may use what is in `foo/`, and a file in `foo/` what `foo.rs`
declares; no circle leads out of a room and back, over another file of it either. What a module re-exports counts as named where it is declared. Only code counts, not documentation and unit tests.

Modules stand in the order of their layers, rooms in `lib.rs` as well as files in `foo.rs`: what is in one of them names those before it, and no other
of the same room.

Usage: scripts/check_layers.py [--list]
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Lowest first; a crate may name those before it.
LAYERS = ["ffr_dynamics", "iga_core", "fe_mesh", "contact_qs", "adaptive", "result_files", "fbimpact"]
# Which of those before it a crate does not name.
STRANGERS = {"iga_core": {"ffr_dynamics"}, "result_files": {"ffr_dynamics", "iga_core", "fe_mesh", "contact_qs", "adaptive"}}
# Modules of a room at most: more are not seen at a glance.
MOST = 12
# Rooms with more, and why.
CROWDED = {("adaptive",): "the table of its `lib.rs` is the map of a run, and no two of its rooms know one thing"}
PATH = re.compile(r"\b(crate|super|self)((?:::super)*)((?:::\w+)+)?(::\{)?")


def code(text):
    """The text without comments and without the unit tests at its end."""
    text = re.split(r"#\[cfg\(test\)\]\s*mod tests \{", text)[0]
    return re.sub(r"//[^\n]*", "", text)


def modules(source):
    """Module path of every file but `main.rs`: `foo/bar.rs`, `foo/mod.rs` -> ("foo", "bar"), ("foo",)."""
    found = {}
    for file in sorted(source.rglob("*.rs")):
        parts = list(file.relative_to(source).with_suffix("").parts)
        if parts == ["main"]:
            continue
        if parts[-1] in ("mod", "lib"):
            parts.pop()
        found[tuple(parts)] = code(file.read_text())
    return found


def branches(text, start):
    """Paths of a `use` tree that begins behind `{` at `start`."""
    depth, prefix, word, out = 1, [], "", []
    stack = []
    i = start
    while depth and i < len(text):
        c = text[i]
        if c == "{":
            stack.append(prefix)
            prefix = prefix + [w for w in word.split("::") if w]
            word, depth = "", depth + 1
        elif c in ",}":
            if word.strip():
                out.append(prefix + [w for w in word.split(" as ")[0].strip().split("::") if w])
            word = ""
            if c == "}":
                depth -= 1
                prefix = stack.pop() if stack else []
        else:
            word += "" if c.isspace() and not word.strip() else c
        i += 1
    return out


def resolve(path, known, exported):
    """The module that declares what `path` names."""
    for _ in range(8):
        module = list(path)
        while module and tuple(module) not in known:
            module.pop()
        item = path[len(module)] if len(path) > len(module) else None
        further = exported.get((tuple(module), item))
        if further is None:
            return tuple(module)
        path = further
    return tuple(module)


def paths(module, text, children):
    """Paths from the root of the crate that `text` of `module` names by crate, super or self, or by the name of one of its `children`."""
    for match in PATH.finditer(text):
        root, ups, tail, tree = match.groups()
        up = len(module) - 1 - ups.count("super")
        base = {"crate": [], "self": list(module), "super": list(module[: max(up, 0)])}[root]
        path = base + [p for p in (tail or "").split("::") if p]
        for branch in branches(text, match.end()) if tree else [[]]:
            yield [p for p in path + branch if p != "self"]
    # Children by their names alone.
    for match in re.finditer(r"\buse ((?:\w+::)+)(\w+|\{)", text):
        head = [p for p in match[1].split("::") if p]
        if head[0] in children:
            for branch in branches(text, match.end()) if match[2] == "{" else [[match[2]]]:
                yield [*module, *head, *(p for p in branch if p != "self")]


def exports(known):
    """What every module re-exports: (module, name) -> path."""
    found = {}
    for module, text in known.items():
        for match in re.finditer(r"\bpub(?:\([^)]*\))? use ((?:\w+::)+)(\w+|\{)(?: as (\w+))?", text):
            head = [p for p in match[1].split("::") if p]
            base = {"crate": [], "self": list(module), "super": list(module[:-1])}.get(head[0])
            if base is None:
                if module + (head[0],) not in known:
                    continue
                base = list(module) + head[:1]
            path = base + head[1:]
            for branch in branches(text, match.end()) if match[2] == "{" else [[match[2]]]:
                if branch:
                    found[module, match[3] or branch[-1]] = path + branch
    return found


def references(module, text, known, exported):
    """Modules that `text` of `module` names."""
    children = {m[-1] for m in known if m and m[:-1] == module}
    return {resolve(path, known, exported) for path in paths(module, text, children)}


def circles(edges):
    """Strongly connected components with more than one member (Tarjan)."""
    index, low, stack, out = {}, {}, [], []

    def visit(v):
        index[v] = low[v] = len(index)
        stack.append(v)
        for w in sorted(edges.get(v, ())):
            if w not in index:
                visit(w)
                low[v] = min(low[v], low[w])
            elif w in stack:
                low[v] = min(low[v], index[w])
        if low[v] == index[v]:
            component = []
            while True:
                component.append(stack.pop())
                if component[-1] == v:
                    break
            if len(component) > 1:
                out.append(sorted(component))

    for v in sorted(edges):
        if v not in index:
            visit(v)
    return out


def circles_of(known):
    """Circles among the files of a crate, and who names whom."""
    exported = exports(known)
    edges = {}
    for module, text in known.items():
        for target in references(module, text, known, exported):
            # The root of a crate only lists its files.
            if module and target and module != target:
                edges.setdefault(module, set()).add(target)
    return [circle for circle in circles(edges) if not is_room(circle)], edges


def source(crate, module):
    """The file of a module of a crate."""
    folder = ROOT / "crates" / crate.replace("_", "-") / "src"
    return folder.joinpath(*module).with_suffix(".rs") if module else folder / "lib.rs"


def rooms(known):
    """Modules with modules of their own, and the names of these in the order of their declaration."""
    for room in sorted({module[:-1] for module in known if module}):
        names = re.findall(r"^(?:pub(?:\([^)]*\))? )?mod (\w+);", known[room], re.M)
        yield room, [name for name in names if (*room, name) in known]


def crowded(crate, known):
    """Rooms with more modules than are seen at a glance."""
    for room, names in rooms(known):
        if len(names) > MOST and (crate, *room) not in CROWDED:
            yield (
                f"{source(crate, room).relative_to(ROOT)}: {len(names)} modules, {MOST} at most: put those that know one thing into a"
                " room of their own, a file `foo.rs` beside its folder `foo/` whose first line says what it knows"
            )


def arrows_up(crate, known, edges):
    """Files that name what stands behind their own module, or behind a room that they are in, where it is declared."""
    for room, names in rooms(known):
        n, level = len(room), {name: i for i, name in enumerate(names)}
        for module, targets in sorted(edges.items()):
            for target in sorted(targets):
                if module[:n] != room or target[:n] != room or min(len(module), len(target)) == n:
                    continue
                if level[target[n]] > level[module[n]]:
                    where = source(crate, room).relative_to(ROOT)
                    yield f"{crate}: {'::'.join(module)} names {'::'.join(target)}, {where} has `{target[n]}` behind `{module[n]}`"


def is_room(circle):
    """Whether a circle is a file with some of its own folder."""
    head = min(circle, key=len)
    return all(module[: len(head)] == head for module in circle)


def tests_left_out():
    """Files of `tests` folders that `all.rs` beside them does not name: nothing would compile or run them."""
    for tests in [ROOT / "tests", *sorted((ROOT / "crates").glob("*/tests"))]:
        named = set(re.findall(r"^mod (\w+);", (tests / "all.rs").read_text(), re.M))
        files = {f.stem for f in tests.glob("*.rs")} | {f.parent.name for f in tests.glob("*/mod.rs")}
        for name in sorted(files - named - {"all"}):
            yield f"{tests.relative_to(ROOT)}: all.rs does not name the module {name}"


def main():
    faults = list(tests_left_out())
    for level, crate in enumerate(LAYERS):
        above = set(LAYERS[level + 1 :]) | STRANGERS.get(crate, set())
        known = modules(ROOT / "crates" / crate.replace("_", "-") / "src")
        for module, text in known.items():
            for name in sorted(above):
                if re.search(rf"\b{name}::", text):
                    faults.append(f"{crate}: {'::'.join(module)} names the crate {name}")
        found, edges = circles_of(known)
        faults += [*crowded(crate, known), *arrows_up(crate, known, edges)]
        for circle in found:
            faults.append(f"{crate}: circle of " + ", ".join("::".join(m) for m in circle))
            if "--list" in sys.argv:
                for a in circle:
                    for b in circle:
                        if b in edges.get(a, ()):
                            faults.append(f"    {'::'.join(a)} -> {'::'.join(b)}")
    print("\n".join(faults) or "layers: no arrow upwards, no circle, no crowd, no test left out")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
