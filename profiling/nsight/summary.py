#!/usr/bin/env python3
"""What bounds each kernel, from the raw pages of Nsight Compute that collect.sh left.

    summary.py FOLDER                         a table of each case
    summary.py FOLDER --markdown              for a page
    summary.py FOLDER --into PAGE             in place of what stands between its two markers
    ncu --import report.ncu-rep --page raw --csv --print-units base | summary.py -

A kernel's floor is the time it would take at the limit it comes nearest to: instructions at four a
cycle and multiprocessor, bytes at the memory's rate, the cache of level 2 at its own.
"""
import argparse
import csv
import json
import pathlib
import re
import statistics
import sys

BEGIN, END = "<!-- summary.py: from here -->", "<!-- summary.py: to here -->"

# By "page kernel" the stage that a kernel belongs to, in the order of a frame.
STAGES = [
    ("g2p", r"\bg2p_kernel"),
    ("grid", r"\b(cut_)?grid_kernel"),
    ("p2g", r"\bp2g_kernel"),
    ("sort: keys", r"\bkey_kernel"),
    ("sort: scan, start", r"-sort .*ScanInit"),
    ("sort: scan", r"-sort .*Scan"),
    ("sort: place", r"\bplace_kernel"),
    ("sort: settled", r"\bsettled_kernel"),
    ("sort: a row", r"\bmove_kernel"),
    ("begin", r"\bbegin_kernel"),
    ("masks: sweep", r"\bsweep_kernel"),
    ("masks", r"\bmask_kernel"),
    ("pose", r"\bpose_kernel"),
    ("surface: renew", r"\brenew_kernel"),
    ("surface: clear", r"\bclear_kernel"),
    ("surface: deposit", r"\bdeposit_kernel"),
    ("surface: list", r"\blist_kernel"),
    ("surface: soften", r"\bsoften_kernel"),
    ("surface: count", r"\bcount_kernel"),
    ("surface: scan, start", r"ScanInit"),
    ("surface: scan", r"Scan"),
    ("surface: march", r"\bmarch_kernel"),
    ("surface: relax", r"\brelax_kernel"),
    ("surface: shade", r"\bshade_kernel"),
]

STALLS = {
    "long_scoreboard": "memory",
    "short_scoreboard": "shared memory",
    "wait": "fixed latency",
    "barrier": "barrier",
    "branch_resolving": "branches",
    "no_instruction": "instruction cache",
    "math_pipe_throttle": "arithmetic units",
    "mio_throttle": "shared memory's queue",
    "lg_throttle": "memory's queue",
    "tex_throttle": "texture's queue",
    "imc_miss": "constants",
    "dispatch_stall": "dispatch",
    "membar": "fence",
    "drain": "stores draining",
    "sleeping": "sleep",
    "misc": "other",
}
# Not waiting: ready, or issuing.
READY = ["selected", "not_selected"]


def stage_of(kernel, page=""):
    for place, (stage, pattern) in enumerate(STAGES):
        if re.search(pattern, f"{page} {kernel}"):
            return place, stage
    return len(STAGES), re.sub(r"[<(].*", "", kernel).split("::")[-1]


def number(text):
    try:
        return float(text.replace(",", ""))
    except ValueError:
        return None


# To seconds, bytes, hertz and plain numbers.
SCALE = {"ns": 1e-9, "nsecond": 1e-9, "us": 1e-6, "usecond": 1e-6, "ms": 1e-3, "msecond": 1e-3,
         "Kbyte": 1e3, "Mbyte": 1e6, "Gbyte": 1e9, "cycle/nsecond": 1e9, "cycle/usecond": 1e6,
         "Ghz": 1e9, "Mhz": 1e6, "GHz": 1e9, "MHz": 1e6, "Kbyte/block": 1e3, "Kinst": 1e3,
         "Minst": 1e6, "Ksector": 1e3, "Msector": 1e6}


def read_raw(lines):
    """Launches of a raw page: the kernel's name and its metrics in base units."""
    rows = csv.reader(line for line in lines if not line.startswith("=="))
    head = next(rows, [])
    if "Kernel Name" not in head:
        sys.exit("summary.py: no column 'Kernel Name': is this the raw page as CSV?")
    units = next(rows)
    for row in rows:
        launch = {}
        for name, unit, cell in zip(head, units, row):
            value = number(cell)
            launch[name] = cell if value is None else value * SCALE.get(unit, 1)
        yield row[head.index("Kernel Name")], launch


def medians(launches):
    names = {n for launch in launches for n, v in launch.items() if isinstance(v, float)}
    return {n: statistics.median(l[n] for l in launches if isinstance(l.get(n), float))
            for n in names}


class Kernel:
    """One kernel of one case: medians over its launches."""

    def __init__(self, stage, launches, particles):
        m = medians(launches)

        def get(name):
            if name not in m:
                sys.exit(f"summary.py: no metric {name}: collect.sh asks for it")
            return m[name]

        self.stage, self.launches = stage, len(launches)
        self.seconds = get("gpu__time_duration.sum")
        cycles = get("sm__cycles_elapsed.avg")
        processors = get("device__attribute_multiprocessor_count")
        self.instructions = get("smsp__inst_executed.sum")
        self.per_particle = self.instructions / particles if particles else None
        self.ipc = get("sm__inst_executed.avg.per_cycle_active")
        self.issue_active = get("smsp__issue_active.avg.pct_of_peak_sustained_active") / 100
        self.lanes = get("smsp__thread_inst_executed_per_inst_executed.ratio")
        self.dram = get("dram__bytes_read.sum") + get("dram__bytes_write.sum")
        self.l2 = 32 * get("lts__t_sectors.sum")
        self.adds = get("lts__t_requests_srcunit_tex_op_red.sum")
        self.busy = get("sm__cycles_active.avg") / cycles
        self.clock = get("sm__cycles_elapsed.avg.per_second")
        self.occupancy = get("sm__warps_active.avg.pct_of_peak_sustained_active") / 100
        self.could = get("sm__maximum_warps_per_active_cycle_pct") / 100
        self.registers = int(get("launch__registers_per_thread"))
        self.shared = (get("launch__shared_mem_per_block_static") +
                       get("launch__shared_mem_per_block_dynamic"))
        self.blocks = int(get("launch__grid_size"))
        self.waves = get("launch__waves_per_multiprocessor")
        waves = get("l1tex__data_pipe_lsu_wavefronts_mem_shared.sum")
        conflicts = get("l1tex__data_bank_conflicts_pipe_lsu_mem_shared.sum")
        self.conflicts = conflicts / waves if waves else 0
        self.processors = int(processors)
        self.shares = {
            "issue": self.instructions / (4 * processors * cycles),
            "DRAM": get("dram__throughput.avg.pct_of_peak_sustained_elapsed") / 100,
            "L2": get("lts__throughput.avg.pct_of_peak_sustained_elapsed") / 100,
            "L1": get("l1tex__throughput.avg.pct_of_peak_sustained_elapsed") / 100,
        }
        self.limit = max(self.shares, key=self.shares.get)
        self.floor = self.seconds * self.shares[self.limit]
        def stalled(reason):
            return m.get(f"smsp__average_warps_issue_stalled_{reason}_per_issue_active.ratio", 0)

        stalls = {name: stalled(reason) for reason, name in STALLS.items()}
        whole = sum(stalls.values()) + sum(stalled(reason) for reason in READY)
        top = sorted(stalls.items(), key=lambda s: -s[1])[:3]
        self.stalls = [(name, value / whole if whole else 0) for name, value in top]

    def bound(self):
        """What holds the kernel, in a few words."""
        if self.shares[self.limit] >= 0.6:
            return {"issue": "instructions", "DRAM": "memory", "L2": "cache of level 2",
                    "L1": "level 1 and shared memory"}[self.limit]
        if self.blocks < self.processors:
            return f"too small: {self.blocks} blocks"
        if self.busy < 0.6:
            return f"uneven or too small: busy {100 * self.busy:.0f} %"
        return "latency: " + self.stalls[0][0]


def particles_in(text):
    found = re.search(r"(\d+) particles|particles +(\d+)", text)
    return int(found.group(1) or found.group(2)) if found else 0


def cases_of(folder):
    """Kernels by case; parts of a case, "-substep", "-frame" and "-sort", are one."""
    cases = {}
    pages = folder.glob("*.csv")
    for page in sorted(pages, key=lambda p: [int(w) if w.isdigit() else w
                                             for w in re.split(r"(\d+)", p.stem)]):
        launches = {}
        said = page.with_suffix(".txt")
        particles = particles_in(said.read_text(errors="replace")) if said.exists() else 0
        with page.open(newline="") as lines:
            for kernel, launch in read_raw(lines):
                launches.setdefault(stage_of(kernel, page.stem), []).append(launch)
        case = cases.setdefault(re.sub(r"-(substep|frame|sort)$", "", page.stem), [particles, []])
        case[1] += [(stage[0], Kernel(stage[1], found, particles))
                    for stage, found in launches.items()]
    for case in cases.values():
        case[1] = [kernel for _, kernel in sorted(case[1], key=lambda k: k[0])]
    return cases


HEAD = ["kernel", "µs", "bound by", "floor µs", "× floor", "issue", "DRAM GB/s", "L2 GB/s",
        "IPC", "lanes", "busy", "occupancy", "registers", "shared KiB", "blocks", "instr.",
        "atomics", "conflicts", "waits for"]
# Columns beside the first of the tables that a page has of a case, narrow enough to be read there.
PAGE = [[1, 3, 4, 15, 16, 17, 2], [5, 6, 7, 8, 9, 10, 11, 12, 13], [14, 18]]


def cells(k, particles):
    def rate(amount):
        return f"{amount / k.seconds / 1e9:.0f}"

    each = "" if k.per_particle is None else f"{k.per_particle:.1f}"
    return [k.stage, f"{1e6 * k.seconds:.1f}", k.bound(), f"{1e6 * k.floor:.1f} {k.limit}",
            f"{k.seconds / k.floor:.1f}" if k.floor else "-", f"{100 * k.shares['issue']:.0f} %",
            f"{rate(k.dram)} ({100 * k.shares['DRAM']:.0f} %)",
            f"{rate(k.l2)} ({100 * k.shares['L2']:.0f} %)", f"{k.ipc:.2f}", f"{k.lanes:.0f}",
            f"{100 * k.busy:.0f} %", f"{100 * k.occupancy:.0f} of {100 * k.could:.0f} %",
            str(k.registers), f"{k.shared / 1024:.1f}", f"{k.blocks} ({k.waves:.1f} waves)", each,
            f"{k.adds / particles:.2f}" if particles and k.adds else "-",
            f"{100 * k.conflicts:.0f} %" if k.conflicts else "-",
            ", ".join(f"{name} {100 * share:.0f} %" for name, share in k.stalls)]


def context_of(folder):
    """What the program said of itself and of the card, in a line; "" where no run left it."""
    report = folder / "run" / "report.json"
    if not report.exists():
        return ""
    said = json.loads(report.read_text()).get("context", {})
    gpu = said.get("gpu", {})
    return (f"Commit {said.get('commit', 'unknown')[:12]}, {gpu.get('name', 'unknown card')}, "
            f"driver {gpu.get('driver', 'unknown')}, {said.get('date', '')[:10]}.")


def tables(cases, markdown):
    lines = []
    for name, (particles, kernels) in cases.items():
        if not kernels:
            continue
        clock = statistics.median(k.clock for k in kernels)
        title = f"{name}: {particles:,} particles".replace(",", " ") + f", {clock / 1e6:.0f} MHz"
        rows = [HEAD] + [cells(k, particles) for k in kernels]
        if markdown:
            lines += [f"### {title}", ""]
            for columns in PAGE:
                part = [[row[c] for c in [0] + columns] for row in rows]
                part.insert(1, ["---"] * len(part[0]))
                lines += ["| " + " | ".join(row) + " |" for row in part] + [""]
        else:
            width = [max(len(row[c]) for row in rows) for c in range(len(HEAD))]
            lines += [title] + ["  ".join(cell.ljust(w) for cell, w in zip(row, width)).rstrip()
                                for row in rows] + [""]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", help="that collect.sh wrote, or - for one raw page")
    parser.add_argument("--markdown", action="store_true")
    parser.add_argument("--into", metavar="PAGE", help="page whose table is replaced")
    parser.add_argument("--particles", type=int, default=0, help="for -")
    given = parser.parse_args()
    if given.folder == "-":
        launches = {}
        for kernel, launch in read_raw(sys.stdin):
            launches.setdefault(stage_of(kernel), []).append(launch)
        kernels = [Kernel(s[1], launches[s], given.particles) for s in sorted(launches)]
        cases, context = {"report": [given.particles, kernels]}, ""
    else:
        folder = pathlib.Path(given.folder)
        cases, context = cases_of(folder), context_of(folder)
    text = tables(cases, given.markdown or given.into)
    if not text:
        sys.exit(f"summary.py: no raw page in {given.folder}")
    if context:
        text = f"{context}\n\n{text}"
    if not given.into:
        print(text)
        return
    page = pathlib.Path(given.into)
    before = page.read_text()
    if before.count(BEGIN) != 1 or before.count(END) != 1:
        sys.exit(f"summary.py: {page} has not the two markers, once each")
    head, rest = before.split(BEGIN)
    tail = rest.split(END)[1]
    page.write_text(f"{head}{BEGIN}\n\n{text}\n{END}{tail}")


if __name__ == "__main__":
    main()
