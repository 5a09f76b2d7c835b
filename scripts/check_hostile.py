#!/usr/bin/env python3
"""Attacks the program with what it cannot want, and refuses any end without a message and a documented exit code, any wait without end, any file
that is lost, and any result of other bits.

Usage: scripts/check_hostile.py PROGRAM [--seed N] [--scenarios N] [--files N] [--signals N] [--limits N] [--also DIR]… [--case KIND:K]… [--keep DIR]

scenarios: shipped ones, and those of `--also`, with bytes, words, keys, values and tables changed, through `check`, every fortieth through `run` as well
files:     damaged, exchanged, folders, pipes, devices, links, through every command that reads or writes such a file
signals:   nine of them, at any instant of a run; what is taken up, or started again, ends with the bits of a run that is left alone
limits:    of addresses, file size, stack, open files, time of processor, room on the disk, and control groups where they can be made

The campaign is `--scenarios 20000 --files 600 --signals 100 --limits 100`; without sizes a small part of it is done in two minutes.
A case depends on seed, kind and number alone: `--case files:17` repeats one. Folders of cases with a fault stay in `--keep`.
Linux only; needs nothing but Python's own library.
"""

import argparse
import collections
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Of all commands (docs/commands.md).
DOCUMENTED = {0, 1, 2, 3, 4, 5, 6, 130}
PATIENCE = 60.0  # s, of a command that has little to do
SHORT = 5.0  # s, after which a run is interrupted, which it obeys
ADDRESSES = 3 << 30  # bytes, for the sake of the machine
KINDS = ("scenarios", "files", "signals", "limits")

End = collections.namedtuple("End", "code out err seconds is_hung")


class Fault(Exception):
    """What the program must not do."""


class Case:
    """A folder of its own, in which the program is called."""

    def __init__(self, program, folder, rng):
        self.program, self.folder, self.rng, self.calls = program, folder, rng, []

    def start(self, arguments, limits=(), cache="off", entered=None):
        def prepare():
            for name in ("SIGHUP", "SIGQUIT", "SIGINT"):
                signal.signal(getattr(signal, name), signal.SIG_DFL)
            if entered:
                pathlib.Path(entered, "cgroup.procs").write_text(str(os.getpid()))
            for what, value in {resource.RLIMIT_CORE: 0, resource.RLIMIT_AS: ADDRESSES, **dict(limits)}.items():
                hard = resource.getrlimit(what)[1]
                resource.setrlimit(what, (value, hard if what == resource.RLIMIT_CPU else value))

        self.calls.append(" ".join(arguments) + "".join(f" [limit {k}: {v}]" for k, v in dict(limits).items()))
        environment = {**os.environ, "FBIMPACT_CACHE": cache, "RAYON_NUM_THREADS": "2"}
        return subprocess.Popen([self.program, *arguments], cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                env=environment, preexec_fn=prepare)

    def wait(self, process, patience, may_be_long):
        """The end of a process: of one that may be long by a signal, of one that hangs by force."""
        began, is_hung = time.monotonic(), False
        try:
            out, err = process.communicate(timeout=SHORT if may_be_long else patience)
        except subprocess.TimeoutExpired:
            try:
                if may_be_long:
                    process.terminate()
                out, err = process.communicate(timeout=patience if may_be_long else 0.01)
            except subprocess.TimeoutExpired:
                is_hung = True
                process.kill()
                out, err = process.communicate()
        return End(process.returncode, out.decode(errors="replace"), err.decode(errors="replace"), time.monotonic() - began, is_hung)

    def call(self, *arguments, patience=PATIENCE, may_be_long=False, may_end=(), **how):
        """Calls the program; raises `Fault` unless it ends as documented."""
        may_be_long = may_be_long and arguments[0] in ("run", "converge")
        end = self.wait(self.start([str(a) for a in arguments], **how), patience, may_be_long)
        if end.is_hung:
            raise Fault(f"does not end within {patience:g} s")
        if end.code not in may_end:
            require(end.code in DOCUMENTED, f"ends with {end.code}: {end.err[-300:]}")
            require(end.code in (0, 1) or re.search(r"error|faults? found", end.err), f"{end.code} without a message: {end.err[-300:]}")
        require("panicked" not in end.err, f"panics: {end.err[-300:]}")
        return end


def require(holds, what):
    if not holds:
        raise Fault(what)


def read(path):
    with open(path, "rb") as file:
        return file.read()


def state(folder):
    """What lies in a folder: of each name the kind, where a link leads, and the contents of files."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        info = path.lstat()
        if path.is_symlink():
            found[name] = os.readlink(path)
        elif path.is_file():
            found[name] = (info.st_size, hash(read(path)) if info.st_size < 1 << 26 else info.st_mtime_ns)
        else:
            found[name] = info.st_mode
    return found


def lost(before, folder, written=()):
    """Names of what is not as it was, outputs aside."""
    after = state(folder)
    return [name for name, what in before.items() if after.get(name) != what and not name.startswith(tuple(written) or "\0")]


# Scenarios

NUMBERS = """0 0.0 -0.0 -1 1 2 3 0.5 1e-3 -1e-3 1e9 1e17 1e-17 1e308 -1e308 1e-320 1e400 nan -nan inf -inf 9223372036854775807 -9223372036854775808
 9223372036854775808 18446744073709551616 0x7fffffff 0b1 0o7 1_000 1__0 00 1979-05-27T07:32:00Z 65536 1000000""".split()
TEXTS = ["", " ", "x", "ball", "ground", "steel", "adaptive", "1 mm", "1 furlong", "-1 mm", "1e400 mm", "nan mm", "t", "1/t", "sin(t)*1e300", "((((", "t" * 5000,
         "(" * 3000, "-" * 3000 + "1", ".", "..", "/", "/dev/zero", "/dev/null", "/dev/stdin", "case.toml", "../x", "no.msh", "\\u0000", "\\U0010ffff", "\\n", "\\u001b[2J",
         "ä", "𝟙", "a.b", "*", "$(touch RAN)", "`touch RAN`", "%s%n", "-", "--help"]
WHOLE = ["[]", "[[]]", "{}", "{ x = 1 }", "[1]", "[1, 2]", "[0.0, 0.0, 0.0]", "[1e308, 1e308, 1e308]", "[nan, 0, 0]", "[1, \"x\"]", "true", "false", "'", '"', "=", "#",
         "[" * 200 + "]" * 200, "[" * 4000, "{ a = " * 500, "[" + "1.0, " * 5000 + "]", "[" + '"x", ' * 500 + "]", '"""', "\0", "1 2", "[0,0,0,1]", "[0.0, 0.0, -1e-300]"]
KEYS = ["x", '""', '"a b"', "ä", "a.b.c", '"\\u0000"', "k" * 3000, "model", "file", "simulation", "bodies", "contacts", "-", "1", "[x]", "a" + ".a" * 2000]
ASSIGNMENT = re.compile(r"^(\s*)([\w.\"-]+)(\s*=\s*)(.*?)(\s*(?:#.*)?)$")
WORD = re.compile(r"[\w.+-]+|\s+|.", re.S)
NUMBER = re.compile(r"(?<![\w.])-?\d+\.?\d*(?:e[+-]?\d+)?(?![\w.])")


def value(rng, old):
    """A value in place of another, given as text."""
    numbers = list(NUMBER.finditer(old))
    which = rng.random()
    if numbers and which < 0.55:
        found = rng.choice(numbers)
        new = rng.choice(NUMBERS)
        if rng.random() < 0.6:
            new = repr(float(found[0]) * rng.choice([-1, 0.5, 0.9, 1.1, 2, 10, 0.1, 1e-3, 1e3, 1e-9, 1e9, 1e30, 1e-30]))
        if found[0].lstrip("-").isdigit() and rng.random() < 0.5:
            new = str(int(found[0]) + rng.choice([-2, -1, 1, 2, 7, 100]))
        return old[: found.start()] + new + old[found.end() :]
    if which < 0.7:
        return rng.choice(NUMBERS)
    return f'"{rng.choice(TEXTS)}"' if which < 0.85 else rng.choice(WHOLE)


def tables(lines):
    """Where each table of a scenario begins and ends."""
    heads = [k for k, line in enumerate(lines) if line.lstrip().startswith("[") and "=" not in line] or [0]
    return list(zip(heads, heads[1:] + [len(lines)]))


def changed_lines(rng, lines, others):
    """One change of keys, values, tables, or lines."""
    at = [k for k, line in enumerate(lines) if ASSIGNMENT.match(line)]
    how = rng.choice(["value"] * 6 + ["key", "delete", "twice", "swap", "given", "table", "head", "foreign", "lines"])
    if how in ("value", "key", "delete", "twice", "swap", "given") and at:
        k = rng.choice(at)
        indent, key, equal, old, rest = ASSIGNMENT.match(lines[k]).groups()
        if how == "value":
            lines[k] = indent + key + equal + value(rng, old) + rest
        elif how == "key":
            cut = rng.randrange(len(key))
            lines[k] = indent + rng.choice(KEYS + [key[:cut] + key[cut + 1 :], key.upper(), key + "s"]) + equal + old + rest
        elif how == "delete":
            del lines[k]
        elif how == "twice":
            lines.insert(rng.randrange(len(lines)), lines[k])
        elif how == "swap":
            other = ASSIGNMENT.match(lines[rng.choice(at)])
            lines[k] = indent + key + equal + other[4] + rest
        else:
            lines.insert(k, rng.choice([line for text in others for line in text.splitlines() if ASSIGNMENT.match(line)]))
        return lines
    begin, end = rng.choice(tables(lines))
    if how == "table":
        chosen = lines[begin:end]
        where = rng.randrange(len(lines) + 1)
        return rng.choice([lines[:begin] + lines[end:], lines[:where] + chosen + lines[where:], lines[:begin] + lines[end:] + chosen, chosen])
    if how == "head" and lines:
        cut = rng.choice(["[", "[["]) + rng.choice(KEYS + ["bodies.x", "bodies.ball", "contacts.impact", "joints.a", "loads.a", "output.stress.a", "materials.steel", "resolution"])
        lines[begin] = cut + "]" * rng.choice([1, 1, 1, 2, 0])
    elif how == "foreign":
        other = rng.choice(others).splitlines()
        begin, end = rng.choice(tables(other))
        where = rng.choice(tables(lines))[0]
        return lines[:where] + other[begin:end] + lines[where:]
    elif lines:
        rng.shuffle(lines) if rng.random() < 0.2 else lines.insert(rng.randrange(len(lines)), rng.choice(WHOLE + KEYS))
    return lines


def changed_words(rng, text, others):
    """Words deleted, repeated, exchanged, or taken from elsewhere."""
    words = WORD.findall(text) or ["x"]
    for _ in range(rng.randint(1, 4)):
        k, j = rng.randrange(len(words)), rng.randrange(len(words))
        how = rng.randrange(5)
        if how == 0:
            words[k] = ""
        elif how == 1:
            words[k] *= 2
        elif how == 2:
            words[k], words[j] = words[j], words[k]
        else:
            words[k] = rng.choice(NUMBERS + WHOLE + WORD.findall(rng.choice(others))[:400])
    return "".join(words)


def changed_bytes(rng, data):
    """Bytes flipped, inserted, removed, repeated, cut off."""
    data = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 8])):
        k = rng.randrange(len(data) + 1)
        how = rng.randrange(6)
        if how == 0 and k < len(data):
            data[k] ^= 1 << rng.randrange(8)
        elif how == 1:
            data[k:k] = rng.choice([b"\0", b"\xff", b"\xef\xbb\xbf", b"\r", b"\r\n", b"\x1b", b"\xe2\x80\xae", b"[", b"]", b'"', b"\\", b"=", b"\xc3", rng.randbytes(9)])
        elif how == 2:
            del data[k : k + rng.choice([1, 3, 40])]
        elif how == 3:
            data[k:k] = data[k : k + rng.choice([2, 60, 700])]
        elif how == 4:
            data = data[:k] if rng.random() < 0.3 else data
        elif k < len(data):
            data[k] = rng.randrange(256)
    return bytes(data)


def scaled(rng, text):
    """Other numbers of a size that may make sense: most of such scenarios have no fault."""
    found = [m for m in NUMBER.finditer(text) if "#" not in text[text.rfind("\n", 0, m.start()) + 1 : m.start()]]
    for m in sorted(rng.sample(found, min(len(found), rng.choice([1, 2, 5]))), key=lambda m: -m.start()):
        factor = rng.choice([0, -1, 0.5, 0.9, 0.999, 1.001, 1.1, 2, 3, 10, 0.1, 1e-3, 1e3])
        new = str(round(int(m[0]) * factor)) if m[0].lstrip("-").isdigit() else repr(float(m[0]) * factor)
        text = text[: m.start()] + new + text[m.end() :]
    return text


def mutated(rng, text, others):
    """A scenario with other numbers, or with one to three changes of any kind, as bytes."""
    if rng.random() < 0.4:
        return scaled(rng, text).encode()
    for _ in range(rng.choice([1, 1, 1, 2, 3])):
        if rng.random() < 0.75:
            text = "\n".join(changed_lines(rng, text.splitlines(), others)) + "\n"
        else:
            text = changed_words(rng, text, others)
    data = text.encode(errors="surrogatepass")
    return changed_bytes(rng, data) if rng.random() < 0.25 else data


def scenarios(case, k, corpus):
    rng = case.rng
    path = rng.choice(corpus.scenarios)
    text = mutated(rng, path.read_text(), corpus.texts)
    for beside in corpus.beside(path):
        os.symlink(beside, case.folder / beside.name)
    scenario = case.folder / "case.toml"
    scenario.write_bytes(text)
    changes = []
    if rng.random() < 0.1:
        key = rng.choice(KEYS + ["simulation.end_time", "bodies.ball.velocity", "contacts.impact.penalty.initial", "materials.steel.density"])
        changes = ["--set", f"{key}={value(rng, '1.0')}".replace("\0", "\\0")]
    before = state(case.folder)
    end = case.call("check", "case.toml", *changes, *(["--cost"] if k % 50 == 7 else []), may_be_long=k % 50 == 7)
    if end.code == 3:
        require("case.toml" in end.err or "--set" in end.err, f"no place: {end.err[-300:]}")
    if k % 40 == 0 and end.code not in (2, 130):
        time_set = ["--set", f"simulation.end_time={rng.choice(['1e-6', '2e-5', '3e-4'])}"] if rng.random() < 0.8 else []
        run = case.call("run", "-q", "--threads", "2", "--memory", "1", "case.toml", "-o", "out.h5", *changes, *time_set, may_be_long=True)
        require(end.code != 3 or run.code == 3 or time_set, f"check refuses what runs: {end.err[-300:]}")
        require(run.code != 3 or end.code == 3 or time_set, f"check accepts what run refuses: {run.err[-300:]}")
        if run.code == 0:
            require(case.call("info", "out.h5").code == 0, "the result cannot be read")
        elif run.code == 130 and "run --resume" in run.err:
            require((case.folder / "out.h5.restart").exists(), "nothing is there to be taken up")
        return end.code, run.code, lost(before, case.folder)
    return end.code, lost(before, case.folder)


# Files

READERS = {
    "result": ["info @", "info @ --json", "compare @ r.h5", "compare r.h5 @", "thin @ -o o.h5", "collect @ -o o.csv", "collect . -o o.h5", "plot @ -o o.d", "plot @ r.h5 -o o.d --png",
               "report @ --no-3d -o o.html", "report @ -o o.html", "metric @ max(contacts.impact.force) steps=scenario", "probe @ --body ball --point 0,0 --csv", "export @ --vtk o.d --plain",
               "run --resume @", "run s.toml -o @ --update", "check @", "run @", "modes @"],
    "part": ["run --resume @", "info @", "run p.toml -o @", "run p.toml -o @ --update"],
    "restart": ["run --resume part.h5", "run p.toml -o part.h5 --update", "run p.toml -o part.h5"],
    "body": ["check b.toml", "modes b.toml", "run -q b.toml -o o.h5", "info @"],
    "spline": ["check n.toml", "modes n.toml"],
    "mesh": ["check m.toml", "mesh-size m.toml -o o.geo", "modes m.toml"],
    "bricks": ["check h.toml", "modes h.toml --body bar"],
    "matrix": ["import-body --stiffness bar.sti --mass bar.mas --nodes bar.inp --dof-map bar.dof --units mm -o o.h5"],
    "curve": ["check s.toml", "run -q s.toml -o o.h5"],
    "rules": ["compare r.h5 r.h5 --tolerances @"],
    "scenario": ["check @", "run -q @ -o o.h5", "modes @", "modes @ --system", "mesh-size @", "export @ --vtk o.d", "export-body @ --body ball -o o.h5", "converge @ -o o.d --jobs 1",
                 "info @", "plot @", "report @ -o o.html", "thin @ -o o.h5"],
    "output": ["run -q s.toml -o @", "thin r.h5 -o @", "collect r.h5 -o @.csv", "report r.h5 --no-3d -o @.html", "plot r.h5 -o @", "export r.h5 --vtk @", "export-body s.toml --body ball -o @",
               "mesh-size m.toml -o @", "converge s.toml -o @ --jobs 1", "man --all @"],
    "cache": ["run -q s.toml -o o.h5"],
}
FILES = {"result": ["r.h5", "thin.h5", "table.h5"], "part": ["part.h5"], "restart": ["part.h5.restart"], "body": ["body.h5", "full.h5"], "spline": ["n.mesh", "n.xml"], "mesh": ["m.msh"],
         "bricks": ["bar_hex20.inp"], "matrix": ["bar.sti", "bar.mas", "bar.inp", "bar.dof"], "curve": ["push.csv"], "rules": ["rules.toml"], "scenario": ["s.toml"],
         "output": ["new", "r.h5", "push.csv"], "cache": ["kept"]}
SCENES = {
    "s.toml": """[simulation]\nend_time = 1.0e-4\n[bodies.ball]\nmodel = "axisymmetric"\nmaterial = "steel"\ngeometry = { shape = "sphere", radius = 10.0e-3 }
reduction = { method = "craig-bampton", modes = 4 }\nposition = [0.0, 0.0, 10.0e-3]\nvelocity = [0.0, 0.0, -0.1]\ndiscretisation = { degree = 3, elements = 4 }
[bodies.floor]\nmodel = "rigid"\ngeometry = { shape = "plane" }\nnormal = [0.0, 0.0, 1.0]
[contacts.impact]\ncontact_body = "ball"\ntarget_body = "floor"\n[loads.push]\nbody = "ball"\npoint = [0.0, 0.0]\nradius = 2.0e-3\nforce_z = { kind = "table", file = "push.csv" }\n""",
    "b.toml": """[simulation]\nend_time = 1.0e-5\n[bodies.ball]\nmodel = "imported"\nfile = "body.h5"\n""",
    "n.toml": """[simulation]\nend_time = 1.0e-5\n[bodies.ball]\nmodel = "solid"\nmaterial = "steel"\ngeometry = { shape = "nurbs", file = "n.mesh", units = "m" }\nreduction = { modes = 4 }\n""",
    "h.toml": """[simulation]\nend_time = 1.0e-5\n[bodies.bar]\nmodel = "mesh"\nfile = "bar_hex20.inp"\nunits = "m"\nmaterial = "steel"\nreduction = { modes = 4 }\n""",
    "push.csv": "t,F\n0,0\n1,1e-3\n",
    "rules.toml": 'rtol = 1.0e-4\n[datasets]\n"bodies/*/elastic_*" = { compare = false }\n',
}


class Corpus:
    """Sound files of every kind, made once."""

    def __init__(self, program, folder, also):
        self.folder = folder / "sound"
        self.folder.mkdir()
        self.scenarios = sorted(path for at in [ROOT / "scenarios", *also] for path in at.glob("**/*.toml"))
        self.texts = [path.read_text() for path in self.scenarios]
        case = Case(program, self.folder, random.Random(0))
        for name, text in SCENES.items():
            (self.folder / name).write_text(text)
        for name in ["matrix_parts/bar.sti", "matrix_parts/bar.mas", "matrix_parts/bar.inp", "matrix_parts/bar.dof", "mesh_parts/bar_hex20.inp"]:
            shutil.copy(ROOT / "tests" / name, self.folder)
        solid = SCENES["n.toml"].replace('shape = "nurbs", file = "n.mesh", units = "m"', 'shape = "box", size = [0.1, 0.1, 0.1]')
        (self.folder / "p.toml").write_text((ROOT / "scenarios/rigid_double_pendulums.toml").read_text())
        (self.folder / "x.toml").write_text(solid)
        sound = [
            "new m --template mesh", "run -q s.toml -o r.h5", "thin r.h5 -o thin.h5", "collect r.h5 -o table.h5", "export-body s.toml --body ball -o body.h5",
            "export-body s.toml --body ball --full -o full.h5", "export-body x.toml --body ball --nurbs mfem -o n.mesh", "export-body x.toml --body ball --nurbs gismo -o n.xml",
            "check s.toml b.toml n.toml h.toml m.toml p.toml",
        ]
        for arguments in sound:
            end = case.call(*arguments.split())
            require(end.code == 0, f"{arguments}: {end.code} {end.err}")
        interrupted = case.start("run -q p.toml -o part.h5 --set simulation.end_time=1000.0".split())
        while not (self.folder / "part.h5.restart").exists() or (self.folder / "part.h5.restart").stat().st_size == 0:
            time.sleep(0.05)
        time.sleep(0.5)
        interrupted.terminate()
        require(interrupted.wait(PATIENCE) == 130, "interrupted")
        require(case.call("run", "-q", "s.toml", "-o", "kept.h5", cache=str(self.folder / "kept")).code == 0, "kept")

    @staticmethod
    def beside(path):
        """What the scenario may name."""
        return [p for p in path.parent.iterdir() if p.suffix in (".msh", ".inp", ".csv", ".h5") and p.is_file()]

    def copy(self, folder):
        shutil.copytree(self.folder, folder, dirs_exist_ok=True, symlinks=True)


def damaged(rng, path, folder):
    """Puts something else in the place of a file; says what."""
    data = read(path) if path.is_file() else b""
    damages = ["cut"] * 3 + ["bits"] * 6 + ["head"] * 4 + ["block", "zeros", "longer"] if data else []
    how = rng.choice(damages + ["other", "other", "empty", "text", "noise", "hole", "folder", "pipe", "zero", "null", "full",
                     "socket", "broken", "circle", "link", "hard", "memory", "environ", "terminal", "unreadable"])
    size = len(data)
    if how in ("cut", "bits", "head", "block", "zeros", "longer"):
        new = bytearray(data)
        if how == "cut":
            new = new[: rng.randrange(size + 1)]
        elif how in ("bits", "head"):
            for _ in range(rng.choice([1, 2, 8, 30])):
                new[rng.randrange(min(size, 4096) if how == "head" else size)] ^= 1 << rng.randrange(8)
        elif how == "longer":
            new += rng.randbytes(rng.choice([1, 8, 5000]))
        else:
            begin, length = rng.randrange(size), rng.choice([4, 8, 16, 256])
            fill = bytes(length) if how == "zeros" else rng.choice([b"\xff" * length, rng.randbytes(length)])
            new[begin : begin + length] = fill
        path.write_bytes(new)
        return how
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
    others = [p for p in sorted(folder.iterdir()) if p.is_file() and not p.is_symlink() and p != path and p.name[0] != "."]
    other = rng.choice(others)
    if how == "socket":
        os.chdir(folder)  # names of sockets are short
        socket.socket(socket.AF_UNIX).bind(path.name)
        return how
    {
        "other": lambda: shutil.copy(other, path),
        "empty": lambda: path.write_bytes(b""),
        "text": lambda: path.write_text("# notes of somebody\n" * rng.choice([1, 3000])),
        "noise": lambda: path.write_bytes(rng.randbytes(rng.choice([1, 100, 100_000]))),
        "hole": lambda: (path.write_bytes(data), os.truncate(path, 1 << 32)),
        "folder": path.mkdir,
        "pipe": lambda: os.mkfifo(path),
        "zero": lambda: path.symlink_to("/dev/zero"),
        "null": lambda: path.symlink_to("/dev/null"),
        "full": lambda: path.symlink_to("/dev/full"),
        "terminal": lambda: path.symlink_to("/dev/tty"),
        "memory": lambda: path.symlink_to("/proc/self/mem"),
        "environ": lambda: path.symlink_to("/proc/self/environ"),
        "broken": lambda: path.symlink_to("nowhere"),
        "circle": lambda: path.symlink_to(path.name),
        "link": lambda: path.symlink_to(other.name),
        "hard": lambda: os.link(other, path),
        "unreadable": lambda: (path.write_bytes(data), path.chmod(0)),
    }[how]()
    return how


# What is no file of the program, whatever stood there before.
NOBODYS = {"text", "noise", "pipe", "socket", "zero", "null", "full", "terminal", "memory", "environ", "circle"}


def files(case, k, corpus):
    rng = case.rng
    corpus.copy(case.folder)
    kind = list(READERS)[k % len(READERS)]
    name = rng.choice(FILES[kind])
    path = case.folder / name
    if kind == "cache":
        path = rng.choice([p for p in sorted(path.rglob("*")) if p.is_file()] or [path])
    elif kind == "spline":
        (case.folder / "n.toml").write_text(SCENES["n.toml"].replace("n.mesh", name))
    elif kind == "body":
        (case.folder / "b.toml").write_text(SCENES["b.toml"].replace("body.h5", name))
    reader = rng.choice(READERS[kind])
    suffix = re.search(r"@(\S*)", reader) if kind == "output" else None
    if suffix:
        path = path.with_name(name + suffix[1])
    how = damaged(rng, path, case.folder)
    case.calls.append(f"({kind} {path.name}: {how})")
    cache = str(case.folder / "kept") if kind == "cache" else "off"
    before = state(case.folder)
    readers = READERS[kind] if kind != "output" else [reader]
    codes = []
    for reader in rng.sample(readers, min(4, len(readers))):
        end = case.call(*reader.replace("@", name).split(), cache=cache, may_be_long=True)
        codes.append(end.code)
        written = ["o.", "kept" if kind == "cache" else "o."]
        if reader.startswith("run") and ("part.h5" in reader or "resume" in reader or "-o" in reader) and end.code in (0, 5, 130):
            written += [name, "part.h5", "nowhere"]  # links to results are followed
        if kind == "output" and end.code == 0:
            written.append(name)
            require(how not in NOBODYS, f"{how} is replaced by {reader}")
        gone = lost(before, case.folder, written)
        require(not gone, f"{reader} ends with {end.code} and loses {gone}")
        if kind == "cache":
            require(end.code == 0 and equal(case, "o.h5", "r.h5"), f"another result with a damaged model: {end.code} {end.err}")
        before = state(case.folder)
    return (kind, *codes)


def equal(case, new, old):
    """Whether two results have the same bits, times of the clock aside."""
    end = case.call("compare", new, old, "--rtol", "0", "--atol", "0", patience=PATIENCE)
    return end.code == 0


# Signals

SIGNALS = ["INT", "TERM", "HUP", "USR1", "USR2", "XCPU", "QUIT", "KILL", "STOP"]
# A second and more each; the reference of each is made once.
RUNS = {"p.toml": "simulation.end_time=1.0", "s.toml": "simulation.end_time=3e-4"}
_references = {}


def reference(case, scenario, corpus):
    """A run that is left alone: its result and its time."""
    if scenario not in _references:
        path = corpus.folder / f"alone-{scenario}.h5"
        end = case.call("run", "-q", "--threads", "2", corpus.folder / scenario, "-o", path, "--set", RUNS[scenario], patience=10 * PATIENCE)
        require(end.code == 0, f"{scenario}: {end.err}")
        _references[scenario] = path, end.seconds
    return _references[scenario]


def waits_for(process, number):
    """Whether a process has a signal held back for the thread that waits for it."""
    try:
        status = read(f"/proc/{process.pid}/status").decode()
    except OSError:
        return True
    return int(re.search(r"SigBlk:\s*(\w+)", status)[1], 16) >> (number - 1) & 1 == 1


def signals(case, k, corpus):
    rng = case.rng
    scenario = rng.choice(list(RUNS))
    alone, seconds = reference(case, scenario, corpus)
    for name in (scenario, "push.csv"):
        shutil.copy(corpus.folder / name, case.folder)
    run = ["run", "-q", "--threads", "2", scenario, "-o", "out.h5", "--set", RUNS[scenario]]
    name, codes = SIGNALS[k % len(SIGNALS)], []
    arguments = run
    for _ in range(rng.choice([1, 1, 2, 3])):
        process = case.start(arguments)
        instant = rng.uniform(0, seconds) if rng.random() < 0.8 else rng.uniform(0, 0.03)
        time.sleep(instant)
        number = getattr(signal, f"SIG{name}")
        is_heard = waits_for(process, number)
        process.send_signal(number)
        case.calls.append(f"({name} after {instant:.3f} s)")
        if name == "STOP":
            time.sleep(rng.uniform(0, 0.3))
            process.send_signal(signal.SIGCONT)
        end = case.wait(process, PATIENCE + 10 * seconds, False)
        require(not end.is_hung, "does not end")
        # In its first milliseconds a process has not yet said what it does with signals, and has not touched a file.
        allowed = {"KILL": (-number, 0), "QUIT": (-number, 0), "STOP": (0,)}.get(name, (130, 0) if is_heard else (130, 0, -number))
        require(end.code in allowed, f"{name}: ends with {end.code}: {end.err[-300:]}")
        require(end.code != 130 or "interrupted" in end.err, f"{name}: no message: {end.err}")
        codes.append(end.code)
        if end.code == 0:
            break
        is_left = (case.folder / "out.h5.restart").exists()
        require(end.code != 130 or "--resume" not in end.err or is_left, f"cannot be taken up: {end.err}")
        arguments = ["run", "-q", "--threads", "2", "--resume", "out.h5"] if is_left and rng.random() < 0.7 else [*run, "--update"]
    if codes[-1] != 0:
        end = case.call(*arguments, patience=PATIENCE + 10 * seconds)
        if end.code == 6 and "--resume" in arguments:
            # Killed before the first state was whole: what it says is to be done.
            require("simulate again" in end.err or "run" in end.err, end.err)
            end = case.call(*run, patience=PATIENCE + 10 * seconds)
        require(end.code == 0, f"taken up: {end.code} {end.err[-300:]}")
    require(equal(case, "out.h5", str(alone)), "another result than that of a run left alone")
    left = [p.name for p in case.folder.iterdir() if p.name not in (scenario, "push.csv", "out.h5")]
    require(not left, f"leaves {left}")
    return (name, *codes)


# Limits

def group(name):
    """A control group of this name, and the file of its limit; None where none can be made."""
    for parent in ("/sys/fs/cgroup/memory", "/sys/fs/cgroup"):
        path = pathlib.Path(parent, name)
        try:
            path.mkdir(exist_ok=True)
        except OSError:
            continue
        for limit in ("memory.limit_in_bytes", "memory.max"):
            if (path / limit).exists():
                return path, path / limit
        path.rmdir()
    return None


COMMANDS = ["run -q --threads 2 s.toml -o out.h5", "run -q --threads 2 p.toml -o out.h5 --set simulation.end_time=1.0", "check s.toml m.toml", "report r.h5 -o out.html", "plot r.h5 -o out.d --png",
            "export r.h5 --vtk out.d --plain", "collect r.h5 thin.h5 -o out.csv", "thin r.h5 -o out.h5", "compare r.h5 r.h5", "info r.h5 --json", "modes s.toml", "export-body s.toml --body ball -o out.h5",
            "metric r.h5 max(contacts.impact.force)", "probe r.h5 --body ball --point 0,0 --csv", "converge s.toml -o out.d --jobs 1", "man run", "run --resume part.h5"]
VALUES = {
    "addresses": (resource.RLIMIT_AS, lambda rng: int(2 ** rng.uniform(24.8, 28.3))),
    "file": (resource.RLIMIT_FSIZE, lambda rng: rng.choice([0, 1, 512, 4096, 20_000, 100_000, 300_000])),
    "stack": (resource.RLIMIT_STACK, lambda rng: rng.choice([16, 32, 64, 100, 128, 256, 512, 1024, 4096]) << 10),
    "open": (resource.RLIMIT_NOFILE, lambda rng: rng.choice([3, 4, 5, 6, 7, 8, 10, 12, 16, 32])),
    "processor": (resource.RLIMIT_CPU, lambda rng: 1),
    "group": (None, lambda rng: rng.choice([20, 30, 40, 50, 60, 90, 150]) * 1_000_000),
    "disk": (None, lambda rng: rng.choice([0, 64, 300, 1000, 4000]) << 10),
}


def limits(case, k, corpus):
    rng = case.rng
    corpus.copy(case.folder)
    kind = list(VALUES)[k % len(VALUES)]
    what, choose = VALUES[kind]
    limit = choose(rng)
    # Its time ends before the run of the pendulums does.
    arguments = rng.choice(COMMANDS) if kind != "processor" else COMMANDS[1]
    case.calls.append(f"({kind} {limit})")
    # The system ends a process by itself that it cannot load (docs/commands.md).
    may_end = {"addresses": (127, -9, -11) if limit < 29 << 20 else (), "stack": (), "open": (127,) if limit < 4 else ()}.get(kind, ())
    before, how, made = state(case.folder), {}, None
    if kind == "group":
        made = group(f"fbimpact-{os.getpid()}")
        if not made:
            return (kind, "skipped")
        made[1].write_text(str(limit))
        how = {"entered": made[0]}
    elif kind == "disk":
        (case.folder / "small").mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={max(limit, 4096)}", "none", case.folder / "small"], stderr=subprocess.DEVNULL).returncode:
            return (kind, "skipped")
        arguments = arguments.replace("out.", "small/out.")
    else:
        how = {"limits": {what: limit}}
    is_part = "part.h5" in arguments
    try:
        end = case.call(*arguments.split(), may_be_long=True, patience=PATIENCE, may_end=may_end, **how)
        gone = lost(before, case.folder, ["part.h5"] if is_part and end.code in (0, 5, 6, 4, 130) else [])
        require(not gone, f"ends with {end.code} and loses {gone}")
        if is_part:
            require(end.code == 0 or (case.folder / "part.h5.restart").exists(), "the part is lost")
        elif end.code and arguments.startswith("run"):
            # What is left is taken up, or the run begins again, where there is room.
            at = case.folder / "small"
            if kind == "disk" and end.code:
                subprocess.run(["mount", "-o", "remount,size=50m", at], check=True)
            again = case.call(*arguments.split(), "--update", patience=4 * PATIENCE)
            require(again.code == 0, f"cannot be run again: {again.code} {again.err[-300:]}")
            output = arguments.split()[arguments.split().index("-o") + 1]
            scenario = "p.toml" if "p.toml" in arguments else None
            require(equal(case, output, str(reference(case, scenario, corpus)[0]) if scenario else "r.h5"), "another result")
    finally:
        if kind == "disk":
            subprocess.run(["umount", case.folder / "small"], stderr=subprocess.DEVNULL)
        if made:
            try:
                made[0].rmdir()
            except OSError:
                pass
    return (kind, end.code)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--seed", default="1")
    for kind, number in zip(KINDS, (100, 28, 9, 14)):
        parser.add_argument(f"--{kind}", type=int, default=number, metavar="N")
    parser.add_argument("--also", action="append", default=[], type=pathlib.Path, metavar="DIR")
    parser.add_argument("--case", action="append", default=[], metavar="KIND:K")
    parser.add_argument("--keep", type=pathlib.Path)
    options = parser.parse_args()
    program = str(pathlib.Path(options.program).resolve())
    cases = [(kind, int(k)) for kind, k in (case.split(":") for case in options.case)]
    cases = cases or [(kind, k) for kind in KINDS for k in range(getattr(options, kind))]
    n_faults, ends = 0, collections.Counter()
    with tempfile.TemporaryDirectory(prefix="hostile") as top:
        top = pathlib.Path(top)
        corpus = Corpus(program, top, options.also)
        for kind, k in cases:
            folder = top / f"{kind}-{k}"
            folder.mkdir()
            case = Case(program, folder, random.Random(f"{options.seed}/{kind}/{k}"))
            try:
                found = globals()[kind](case, k, corpus)
                if kind == "scenarios":
                    require(not found[-1], f"loses {found[-1]}")
                    found = found[:-1]
                ends[(kind, *found)] += 1
            except Fault as fault:
                n_faults += 1
                print(f"{kind}:{k}: {'; '.join(case.calls)}\n    {fault}", flush=True)
                if options.keep:
                    shutil.copytree(folder, options.keep / folder.name, symlinks=True, dirs_exist_ok=True, ignore=lambda at, names: [n for n in names if not (pathlib.Path(at, n).is_file() or pathlib.Path(at, n).is_dir())])
            finally:
                os.chdir(ROOT)
                shutil.rmtree(folder, ignore_errors=True)
            if (k + 1) % 500 == 0:
                print(f"{kind}: {k + 1} done", flush=True)
    of_kind = collections.defaultdict(collections.Counter)
    for (kind, *codes), n in ends.items():
        of_kind[kind].update({str(c): n for c in codes})
    for kind, counts in of_kind.items():
        print(f"hostile: {kind}: {', '.join(f'{what} × {n}' for what, n in sorted(counts.items()))}")
    print(f"hostile: {len(cases)} cases, {n_faults} faults")
    return 1 if n_faults else 0


if __name__ == "__main__":
    sys.exit(main())
