#!/usr/bin/env python3
"""Draws what `knead verify` measured, from its verify.json, as PNG beside it.

usage: plot_verify.py VERIFY_JSON [--out FOLDER]

Needs matplotlib (Debian: python3-matplotlib); ends with 3 where Python has none.
"""
import argparse
import math
import sys
import textwrap

from plot import COLOURS, WIDTH, Drawing, Wrong, at, brief, number, read, run

FRONT = "error against run time: "
MARGIN = "margin of the substep: "
ENDINGS = {"stable": "#cfe3c4", "guarded": "#f3e3a8", "refused": "#c9dcec", "slow": "#dddddd",
           "FAILED": "#e8a090"}
OFTEN = {1: "o", 4: "v", 8: "s", 16: "P", 27: "^"}  # marker by particles a cell
SURFACE = "surface of a ball"


def fronts(rows):
    """Points of every scene: dictionaries with `error`, `seconds` and what was varied. `counted` is
    what an error counts as: that of the same setting on finer cells, if that is more."""
    scenes = {}
    for row in rows:
        table = str(at(row, "table") or "")
        if not table.startswith(FRONT):
            continue
        numbers = at(row, "numbers") or {}
        point = {k: number(v) for k, v in numbers.items()}
        unit = next((k for k in point if k.startswith("error_")), None)
        if unit is None or not point[unit] or not point.get("seconds"):
            continue
        point.update(error=point[unit], unit=unit[len("error_"):].replace("percent", "%"),
                     front=at(row, "outcome") == "front",
                     counted=point.get("counted") or point[unit])
        scenes.setdefault(table[len(FRONT):], []).append(point)
    return scenes


def decades(axis):
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
    low, high = axis.get_view_interval()
    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 200 * low else (1,), numticks=99))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda x, _: brief(x)))


def work_precision(scenes, note):
    """A panel a scene: every setting, the front, and the defaults."""
    across = 2
    down = math.ceil(len(scenes) / across)
    drawing = Drawing("Error against run time", note, 110 + 250 * down, panels=(down, across))
    cells = sorted({p["cells"] for points in scenes.values() for p in points})
    colour = {c: COLOURS[k % len(COLOURS)] for k, c in enumerate(cells)}
    for axes, (name, points) in zip(drawing.panels, scenes.items()):
        for p in points:
            axes.plot(p["seconds"], p["error"], OFTEN.get(p["per_cell"], "D"), markersize=5,
                      color=colour[p["cells"]], alpha=0.85,
                      fillstyle="none" if p["double"] else "full")
        front = sorted((p["seconds"], p["counted"]) for p in points if p["front"])
        axes.plot([x for x, _ in front], [y for _, y in front], color="#999999", linewidth=1,
                  zorder=1)
        usual = [p for p in points if p["default"]]
        axes.plot([p["seconds"] for p in usual], [p["error"] for p in usual], "o", markersize=12,
                  fillstyle="none", color="#222222", markeredgewidth=1.2)
        axes.set_xscale("log")
        axes.set_yscale("log")
        decades(axes.xaxis)
        decades(axes.yaxis)
        axes.tick_params(labelsize=9)
        axes.set_title(name, size=11, loc="left")
        axes.set_ylabel(f"error, {points[0]['unit']}", size=9)
        axes.grid(color="#eeeeee")
        axes.set_xlabel("seconds", size=9)
    for axes in drawing.panels[len(scenes):]:
        axes.set_axis_off()
    from matplotlib.lines import Line2D
    dots = [(f"{c:g}", Line2D([], [], color=colour[c], marker="o", linestyle="")) for c in cells]
    dots[0] = ("cells/m: " + dots[0][0], dots[0][1])
    used = sorted({p["per_cell"] for points in scenes.values() for p in points})
    dots += [(f"{n:g} a cell", Line2D([], [], color="#777777", marker=OFTEN.get(n, "D"),
                                      linestyle="")) for n in used]
    dots += [("double", Line2D([], [], color="#777777", marker="s", fillstyle="none",
                               linestyle="")),
             ("defaults", Line2D([], [], color="#222222", marker="o", markersize=11,
                                 fillstyle="none", linestyle="")),
             ("front", Line2D([], [], color="#999999"))]
    drawing.legend([h for _, h in dots], [n for n, _ in dots], 0.9)
    return drawing


def convergence(scenes, note):
    """The defaults' error over cells, both over those of the scene's coarsest; slopes 1 and 2."""
    from matplotlib.ticker import FixedLocator, NullLocator
    drawing = Drawing("Convergence of the defaults", note)
    axes, handles, names, places = drawing.axes, [], [], {1.0}
    for k, (name, points) in enumerate(scenes.items()):
        usual = sorted((p["cells"], p["error"]) for p in points if p["default"])
        if len(usual) < 2:
            continue
        cells, error = usual[0]
        series = [(c / cells, e / error) for c, e in usual]
        handles += axes.plot(*zip(*series), marker="o", linewidth=2,
                             color=COLOURS[k % len(COLOURS)])
        names.append(f"{name}: 1 is {error:.2g} {points[0]['unit']} at {cells:g} cells/m")
        places.update(c for c, _ in series)
    if not names:
        drawing.nothing()
        return drawing
    far = max(places)
    for order, style in ((1, (0, (6, 3))), (2, (0, (2, 2)))):
        axes.plot([1, far], [1, far ** -order], color="#999999", linestyle=style, linewidth=1,
                  zorder=1)
        axes.annotate(f"order {order}", (far, far ** -order), xytext=(4, 0),
                      textcoords="offset points", color="#777777", size=9, va="center",
                      annotation_clip=False)
    axes.set_xscale("log")
    axes.set_yscale("log")
    decades(axes.xaxis)
    decades(axes.yaxis)
    axes.xaxis.set_major_locator(FixedLocator(sorted(places)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xlabel("cells over the coarsest")
    axes.set_ylabel("error over that on the coarsest")
    axes.grid(color="#e6e6e6")
    axes.margins(x=0.08)
    axes.legend(handles, names, loc="lower left", frameon=False, fontsize=9)
    return drawing


def ball(rows, note):
    """A dot a surface: how rough, over the time that it takes."""
    drawing = Drawing("The surface of a ball, by nodes a cell and smoothing", note)
    axes = drawing.axes
    for row in rows:
        numbers = {k: number(v) for k, v in (at(row, "numbers") or {}).items()}
        if not numbers.get("rough_mm") or not numbers.get("seconds"):
            continue
        place = (1e3 * numbers["seconds"], numbers["rough_mm"])
        front = at(row, "outcome") == "front"
        axes.plot(*place, "o", markersize=6, color=COLOURS[1],
                  fillstyle="full" if front else "none")
        if numbers.get("default"):
            axes.plot(*place, "o", markersize=13, fillstyle="none", color="#222222")
        axes.annotate(str(at(row, "name")).replace(" nodes a cell", ""), place, xytext=(8, 4),
                      textcoords="offset points", size=8)
    axes.set_xscale("log")
    axes.set_yscale("log")
    decades(axes.xaxis)
    decades(axes.yaxis)
    axes.margins(x=0.1, y=0.1)
    axes.set_xlabel("ms a surface; full: on the front; circle: the default")
    axes.set_ylabel("distance from its mean sphere, rms, mm")
    axes.grid(color="#e6e6e6")
    return drawing


def stability(rows, note):
    """A coloured cell a case, in the order of the report."""
    from matplotlib.patches import Rectangle
    across = 5
    down = math.ceil(len(rows) / across)
    drawing = Drawing("How the cases of the stability map ended", note, 84 + 30 * down, left=24,
                      bottom=30)
    axes = drawing.axes
    axes.set_axis_off()
    axes.set_xlim(0, across)
    axes.set_ylim(down, 0)
    counts = dict.fromkeys(ENDINGS, 0)
    for k, row in enumerate(rows):
        column, line = divmod(k, down)
        ending = str(at(row, "outcome") or "").split(":")[0]
        if ending in counts:
            counts[ending] += 1
        axes.add_patch(Rectangle((column + 0.02, line + 0.06), 0.96, 0.88,
                                 facecolor=ENDINGS.get(ending, "#ffffff"),
                                 edgecolor="#b03020" if ending == "FAILED" else "none"))
        text = textwrap.wrap(str(at(row, "name")), 29)
        if len(text) > 2:
            text = [text[0], text[1][:27] + " …"]
        axes.text(column + 0.05, line + 0.5, "\n".join(text), size=7.5, va="center",
                  linespacing=1.1)
    drawing.legend([Rectangle((0, 0), 1, 1, facecolor=ENDINGS[k]) for k in ENDINGS],
                   [f"{k} ({n})" for k, n in counts.items()])
    return drawing


def margins(checks, note):
    """A bar a case, and what it must reach."""
    drawing = Drawing("How much longer than the default a substep may be", note,
                      130 + 30 * len(checks), left=190, bottom=58)
    axes = drawing.axes
    values = [number(at(c, "measured")) or 0 for c in checks]
    bound = number(at(checks[0], "bound")) or 0
    axes.barh(range(len(checks)), values, height=0.66,
              color=[ENDINGS["FAILED"] if at(c, "verdict") == "FAILED" else ENDINGS["stable"]
                     for c in checks])
    axes.axvline(bound, color="#444444", linewidth=1, linestyle=(0, (4, 3)))
    axes.text(bound, -0.62, f"at least {brief(bound)}", size=9, ha="center", va="bottom")
    for k, value in enumerate(values):
        axes.text(value + 0.02, k, brief(value), va="center", size=10)
    axes.set_yticks(range(len(checks)), [str(at(c, "name"))[len(MARGIN):] for c in checks])
    axes.set_ylim(len(checks) - 0.5, -0.5)
    axes.set_xlim(0, 1.15 * max(values + [bound, 1]))
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel("times the default; red: below the bound")
    return drawing


def drawings(verify):
    """File name and drawing of all that was measured."""
    context = at(verify, "context") or {}
    where = at(context, "device") or at(context, "gpu", "name") or at(context, "cpu") or "unknown"
    note = " · ".join([str(where), "commit " + str(context.get("commit", "unknown"))[:12],
                       str(context.get("date", ""))[:10]])
    scenes = fronts(verify["rows"])
    if scenes:
        yield "workprecision.png", work_precision(scenes, note)
        yield "convergence.png", convergence(scenes, note)
    surfaces = [r for r in verify["rows"] if str(at(r, "table") or "").startswith(SURFACE)]
    if surfaces:
        yield "surface.png", ball(surfaces, note)
    cases = [r for r in verify["rows"] if at(r, "table") == "stability map"]
    if cases:
        yield "stability.png", stability(cases, note)
    checks = [c for c in verify["checks"] if str(at(c, "name") or "").startswith(MARGIN)]
    if checks:
        yield "margins.png", margins(checks, note)


def drawn(options):
    verify = read(options.verify)
    if at(verify, "schema") != "knead.verify/1" or not isinstance(at(verify, "rows"), list) or \
            not isinstance(at(verify, "checks"), list):
        raise Wrong(f"{options.verify}: expected \"schema\": \"knead.verify/1\", \"rows\" and "
                    "\"checks\"")
    return drawings(verify)


def main():
    parser = argparse.ArgumentParser(description="Draws what knead verify measured.")
    parser.add_argument("verify", help="verify.json of knead verify")
    parser.add_argument("--out", help="folder of the drawings; that of verify.json if not given")
    options = parser.parse_args()
    return run(lambda: drawn(options), options.out, options.verify)


if __name__ == "__main__":
    sys.exit(main())
