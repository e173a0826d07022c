#!/usr/bin/env python3
"""Draws what `knead bench` measured, from its bench.json, as SVG beside it.

usage: plot.py BENCH_JSON [--out FOLDER] [--peers PEERS_JSON]

Needs matplotlib (Debian: python3-matplotlib); ends with 3 where Python has none.
"""
import argparse
import json
import math
import os
import sys
import tempfile

COLOURS = ["#b5512b", "#2f6f8f", "#7a8f2f", "#7b4f9d", "#c69214",
           "#4d4d4d", "#d98c7a", "#8cb8cc", "#3f5c1e", "#b49bc9"]
# bench.json has its stages by name; this is their order in time.
STAGES = ["project", "sort", "pose", "p2g", "grid", "g2p", "clear", "deposit", "list", "soften",
          "count", "scan", "emit", "sort by tile", "blend", "march", "relax", "shade"]
PAPER = {"paper: grid": ("paper-grid.svg", "nodes per axis"),
         "paper: substeps": ("paper-substeps.svg", "substeps a frame"),
         "paper: particles per cell": ("paper-particles.svg", "particles per cell")}
BARS = {"stages": ("stages.svg", "Stages of one 11.1 ms frame"),
        "localized": ("localized.svg", "A frame of clay of which 5 % is in hands"),
        "surface": ("surface.svg", "Making the surface"),
        "splats": ("splats.svg", "Splats for both eyes")}
WIDTH, HEIGHT = 760, 460  # points
LETTERS = 11  # [pt]


class Wrong(Exception):
    """A file that cannot be used: its path, where, what was expected."""


class Unwritten(Exception):
    """A file that cannot be written: its path and the reason."""


def read(path):
    try:
        with open(path, encoding="utf-8") as file:
            return json.load(file)
    except OSError as problem:
        raise Wrong(f"{path}: {problem.strerror}") from problem
    except ValueError as problem:
        raise Wrong(f"{path}: cannot be read as JSON: {problem}") from problem


def number(value):
    """A finite number, or None."""
    good = isinstance(value, (int, float)) and not isinstance(value, bool)
    return float(value) if good and math.isfinite(value) else None


def at(value, *keys):
    for key in keys:
        value = value.get(key) if isinstance(value, dict) else None
    return value


def brief(x):
    """A number as short as it stays clear: 12 k, 3.5 M, 0.02."""
    for bound, scale, unit in ((1e9, 1e9, " G"), (1e6, 1e6, " M"), (1e4, 1e3, " k")):
        if abs(x) >= bound:
            return f"{x / scale:.3g}{unit}"
    return f"{x:.4g}"


def mark(size, above):
    """The nearest of 1, 2 and 5 times a power of ten that is not on the other side."""
    decade = 10.0 ** math.floor(math.log10(size))
    marks = [decade, 2 * decade, 5 * decade, 10 * decade]
    return min(m for m in marks if m >= size) if above else max(m for m in marks if m <= size)


class Drawing:
    """One figure: its title, its legend in one line below, the note at its foot."""

    def __init__(self, title, note, height=HEIGHT, left=84, bottom=84, panels=None):
        """`panels`: rows and columns of axes instead of one."""
        from matplotlib.figure import Figure
        self.figure = Figure(figsize=(WIDTH / 72, height / 72))
        self.height, self.left = height, left
        if panels:
            self.panels = list(self.figure.subplots(*panels, squeeze=False).flat)
            self.figure.subplots_adjust(left=72 / WIDTH, right=1 - 24 / WIDTH,
                                        bottom=72 / height, top=1 - 96 / height, wspace=0.28,
                                        hspace=0.42)
            self.axes = self.panels[0]
        else:
            self.axes = self.figure.add_axes((left / WIDTH, bottom / height,
                                              (WIDTH - left - 24) / WIDTH,
                                              (height - bottom - 72) / height))
        self.figure.text(24 / WIDTH, 1 - 28 / height, title, size=15, weight="bold")
        self.figure.text(24 / WIDTH, 12 / height, note, size=9, color="#777777")

    def legend(self, handles, labels, length=1.0):
        """One row, in smaller letters where it would be wider than the drawing."""
        def made(size):
            return self.figure.legend(handles, labels, loc="center left", frameon=False,
                                      borderpad=0, ncol=len(labels), fontsize=size,
                                      bbox_to_anchor=(24 / WIDTH, 1 - 48 / self.height),
                                      handlelength=length, handletextpad=0.5, columnspacing=1.2)
        usual = made(LETTERS)
        wide = usual.get_window_extent().width / self.figure.bbox.width
        room = 1 - 48 / WIDTH
        if wide > room:
            usual.remove()
            made(LETTERS * room / wide)

    def nothing(self):
        self.axes.set_axis_off()
        self.figure.text(24 / WIDTH, 0.5, "nothing was measured")

    def write(self, path):
        """The old file or the new one, never half."""
        folder, name = os.path.split(path)
        partial = None
        try:
            kind = os.path.splitext(name)[1]
            handle, partial = tempfile.mkstemp(kind, name + ".partial-", folder or ".")
            with os.fdopen(handle, "wb") as file:
                self.figure.savefig(file, format=kind[1:], dpi=144, facecolor="white",
                                    metadata={"Date": None} if kind == ".svg" else
                                    {"Software": None})
                file.flush()
                os.fsync(file.fileno())
            mask = os.umask(0)
            os.umask(mask)
            os.chmod(partial, 0o666 & ~mask)
            os.replace(partial, path)
            partial = None
        except OSError as problem:
            raise Unwritten(f"{path}: cannot be written: {problem.strerror}") from problem
        finally:
            if partial:
                os.unlink(partial)


def lines(drawing, series, labels, logarithmic):
    """`series`: name, points, whether it was measured elsewhere. What has no place is left out."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullLocator
    axes, handles, names = drawing.axes, [], []
    shown = [(name, [(x, y) for x, y in points
                     if x is not None and y is not None
                     and (x > 0 or not logarithmic[0]) and (y > 0 or not logarithmic[1])], theirs)
             for name, points, theirs in series]
    if not any(points for _, points, _ in shown):
        return drawing.nothing()
    for k, (name, points, theirs) in enumerate(shown):
        if not points:
            continue
        handles += axes.plot([x for x, _ in points], [y for _, y in points], color=COLOURS[k],
                             linewidth=2, marker="o", markersize=5,
                             linestyle=(0, (4, 2.5)) if theirs else "-")
        names.append(name)
    for axis, log, k in ((axes.xaxis, logarithmic[0], 0), (axes.yaxis, logarithmic[1], 1)):
        values = [p[k] for _, points, _ in shown for p in points]
        low, high = min(values), max(values)
        if log:
            low, high = mark(low / 1.02, False), mark(high * 1.02, True)
            (axes.set_xscale if k == 0 else axes.set_yscale)("log")
            few = math.log10(high / low) < 3
            axis.set_major_locator(LogLocator(subs=(1, 2, 5) if few else (1,), numticks=99))
            axis.set_minor_locator(NullLocator())
        else:
            room = 0.06 * max(high - low, 1e-9)
            low, high = (low - room if k == 0 or low < 0 else 0), high + room
        (axes.set_xlim if k == 0 else axes.set_ylim)(low, high)
        axis.set_major_formatter(FuncFormatter(lambda x, _: brief(x)))
    if not logarithmic[0] and len(shown[0][1]) <= 12:
        axes.xaxis.set_major_locator(FixedLocator([x for x, _ in shown[0][1]]))
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    axes.grid(color="#e6e6e6")
    drawing.legend(handles, names, 2.0)
    return None


def paper(rows, suite, label, theirs, note):
    surface = [(number(at(r, "frame_ms", "median")), number(at(r, "surface_ms"))) for r in rows]
    places = [number(at(r, "at")) for r in rows]
    series = [("substeps", [(x, f) for x, (f, _) in zip(places, surface)], False),
              ("substeps and surface", [(x, None if f is None else f + (s or 0))
                                        for x, (f, s) in zip(places, surface)], False)]
    sweep = at(theirs, "frames_per_second", suite) or {}
    rates = [number(f) for f in at(sweep, "rate") or []]
    if rates:
        series.append((str(at(theirs, "label") or "the paper"),
                       [(number(x), 1e3 / f if f else None)
                        for x, f in zip(at(sweep, "at") or [], rates)], True))
    drawing = Drawing(f"A frame of the squeeze by {label}", note)
    lines(drawing, series, (label, "ms a frame"), (False, True))
    return drawing


def scale(rows, device, note):
    drawing = Drawing("Particle-substeps per second of the squeeze", note)
    rates = [number(at(r, "items_per_second")) for r in rows]
    lines(drawing, [(device, [(number(at(r, "at")), None if rate is None else 1e-9 * rate)
                              for r, rate in zip(rows, rates)], False)],
          ("particles", "10⁹ a second"), (True, True))
    return drawing


def bar_name(row):
    """"0.137 M particles, 64³"; of a case that says more in its name, that."""
    name = str(at(row, "name") or "")
    if at(row, "suite") == "splats":
        return name.removeprefix("splats: ")
    begin, end = name.find(": "), name.rfind(", ")
    if not at(row, "stages_ms") and 0 <= begin < end:
        return name[begin + 2:end]
    nodes = at(row, "nodes") or [0]
    return f"{1e-6 * (number(at(row, 'particles')) or 0):.3g} M particles, {nodes[0]}³"


def bars(rows, title, note):
    """A bar a case, of its stages; whole where it was not taken apart."""
    height = 72 + 30 * len(rows) + 40
    drawing = Drawing(title, note, height, left=210, bottom=40)
    parts = []
    for row in rows:
        stages = {k: number(v) for k, v in (at(row, "stages_ms") or {}).items() if k != "fetch"}
        if not stages:
            stages = {"whole": number(at(row, "frame_ms", "median"))}
        parts.append({k: v for k, v in stages.items() if v is not None and v > 0})
    order = {k: STAGES.index(k) if k in STAGES else len(STAGES) for p in parts for k in p}
    names = sorted(order, key=lambda k: (k == "whole", order[k], k))
    if not names:
        drawing.nothing()
        return drawing
    left, handles = [0.0] * len(rows), []
    for k, name in enumerate(names):
        widths = [p.get(name, 0.0) for p in parts]
        handles.append(drawing.axes.barh(range(len(rows)), widths, left=left, height=0.72,
                                         color=COLOURS[k % len(COLOURS)]))
        left = [a + b for a, b in zip(left, widths)]
    axes = drawing.axes
    axes.set_xlim(0, 1.16 * max(left))
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_yticks(range(len(rows)), [bar_name(r) for r in rows])
    axes.tick_params(length=0)
    axes.xaxis.set_visible(False)
    for side in axes.spines.values():
        side.set_visible(False)
    for k, total in enumerate(left):
        axes.text(total + 0.012 * max(left), k, f"{brief(total)} ms", va="center")
    drawing.legend(handles, names)
    return drawing


def drawings(bench, peers):
    """File name and drawing of every suite that there is."""
    context = at(bench, "context") or {}
    note = " · ".join([str(context.get("device", "unknown")),
                       "commit " + str(context.get("commit", "unknown"))[:12],
                       str(context.get("date", ""))[:10]])
    suites = {}
    for row in bench["rows"]:
        suites.setdefault(at(row, "suite"), []).append(row)
    for suite, (name, label) in PAPER.items():
        if suite in suites:
            yield name, paper(suites[suite], suite, label, at(peers, "paper"), note)
    if "scale" in suites:
        yield "scale.svg", scale(suites["scale"], str(context.get("device", "unknown")), note)
    for suite, (name, title) in BARS.items():
        if suite in suites:
            yield name, bars(suites[suite], title, note)


def run(make, folder, source):
    """Writes what `make` yields, names and drawings, to the folder or beside `source`; tells their
    paths. Gives the exit code."""
    script = os.path.basename(sys.argv[0])
    try:
        import matplotlib
    except ImportError:
        print(f"{script}: Python has no matplotlib here (Debian: python3-matplotlib)",
              file=sys.stderr)
        return 3
    matplotlib.use("agg")
    matplotlib.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "knead",
                                "font.size": LETTERS, "axes.edgecolor": "#555555",
                                "axes.spines.top": False, "axes.spines.right": False,
                                "text.color": "#222222"})
    try:
        for name, drawing in make():
            path = os.path.join(folder or os.path.dirname(source) or ".", name)
            drawing.write(path)
            print(path)
    except Wrong as problem:
        print(f"{script}: {problem}", file=sys.stderr)
        return 2
    except Unwritten as problem:
        print(f"{script}: {problem}", file=sys.stderr)
        return 5
    return 0


def drawn(options):
    bench = read(options.bench)
    if at(bench, "schema") != "knead.bench/1" or not isinstance(at(bench, "rows"), list):
        raise Wrong(f"{options.bench}: expected \"schema\": \"knead.bench/1\" and \"rows\"")
    peers = read(options.peers) if os.path.exists(options.peers) else None
    if peers is None:
        print(f"plot.py: no {options.peers}: drawn without others' figures", file=sys.stderr)
    return drawings(bench, peers)


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    parser = argparse.ArgumentParser(description="Draws what knead bench measured.")
    parser.add_argument("bench", help="bench.json of knead bench")
    parser.add_argument("--out", help="folder of the drawings; that of bench.json if not given")
    parser.add_argument("--peers", default=os.path.join(here, "peers.json"),
                        help="figures of others; peers.json beside this script if not given")
    options = parser.parse_args()
    return run(lambda: drawn(options), options.out, options.bench)


if __name__ == "__main__":
    sys.exit(main())
