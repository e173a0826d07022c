#!/usr/bin/env python3
"""Warp instructions of each form of bench_micro, from Nsight Compute's counter.

    ncu --nvtx --metrics smsp__inst_executed.sum -o counted bench_micro --once
    ncu --import counted.ncu-rep --nvtx --page raw --csv | instructions.py > counted.csv
    bench_micro --instructions counted.csv

Reads the raw page from standard input; a form's kernels are those within its profiler range.
"""
import collections
import csv
import re
import sys


def main():
    metric = "smsp__inst_executed.sum"
    rows = csv.reader(line for line in sys.stdin if not line.startswith("=="))
    head = next(rows, [])
    if metric not in head:
        sys.exit(f"instructions.py: no column {metric}: is this the raw page as CSV?")
    at = head.index(metric)
    units = next(rows)
    scale = {"": 1, "inst": 1, "Kinst": 1e3, "Minst": 1e6, "Ginst": 1e9}.get(units[at])
    if scale is None:
        sys.exit(f"instructions.py: what is {units[at]!r}?")
    counts = collections.Counter()
    strangers = 0
    for row in rows:
        found = {m.group(1).strip() for cell in row for m in re.finditer(r'micro/([^:"]+)', cell)}
        if len(found) == 1:
            counts[found.pop()] += scale * float(row[at].replace(",", ""))
        else:
            strangers += 1
    if not counts:
        sys.exit("instructions.py: no kernel within a range micro/...: was --nvtx given twice?")
    print("instructions,name")
    for name, count in counts.items():
        print(f"{count:.0f},{name}")
    if strangers:
        print(f"instructions.py: {strangers} kernels outside of any form", file=sys.stderr)


if __name__ == "__main__":
    main()
