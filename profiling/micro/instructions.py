#!/usr/bin/env python3
"""Warp instructions of each form of bench_micro, from Nsight Compute's counter.

    ncu --metrics smsp__inst_executed.sum -o counted bench_micro --once names.txt
    ncu --import counted.ncu-rep --page raw --csv > raw.csv
    instructions.py names.txt raw.csv > counted.csv
    bench_micro --instructions counted.csv

A form's kernels are those between two of mark_kernel.
"""
import csv
import sys

METRIC = "smsp__inst_executed.sum"


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: instructions.py NAMES RAW_PAGE")
    with open(sys.argv[1]) as file:
        names = file.read().splitlines()
    with open(sys.argv[2], newline="") as page:
        rows = list(csv.reader(line for line in page if not line.startswith("==")))
    if len(rows) < 2 or METRIC not in rows[0] or "Kernel Name" not in rows[0]:
        sys.exit(f"instructions.py: no column {METRIC}: is this the raw page as CSV?")
    at, kernel = rows[0].index(METRIC), rows[0].index("Kernel Name")
    scale = {"": 1, "inst": 1, "Kinst": 1e3, "Minst": 1e6, "Ginst": 1e9}.get(rows[1][at])
    if scale is None:
        sys.exit(f"instructions.py: what is {rows[1][at]!r}?")
    counts, inside = [], False
    for row in rows[2:]:
        if "mark_kernel" in row[kernel]:
            inside = not inside
            if inside:
                counts.append(0)
        elif inside:
            counts[-1] += scale * float(row[at].replace(",", ""))
    if inside or len(counts) != len(names):
        sys.exit(f"instructions.py: {len(names)} forms were named, {len(counts)} counted")
    print("instructions,name")
    for name, count in zip(names, counts):
        print(f"{count:.0f},{name}")


if __name__ == "__main__":
    main()
