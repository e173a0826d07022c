#!/usr/bin/env python3
"""Writes logs of commands and recorded hands of the case studies (docs/guide/case-studies.md):
NAME.jsonl and NAME.hands beside this file. docs/method/hands.md has the sizes of the tools.
usage: scenes/cases/make.py PROGRAM [NAME...]"""
import json
import math
import os
import subprocess
import sys
import tempfile

here = os.path.dirname(os.path.abspath(__file__))
PALM, INDEX = 0, 9  # joints of OpenXR: the palm, the index finger's distal joint


# Quaternions [w, x, y, z] and vectors.
def times(a, b):
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (aw * bw - ax * bx - ay * by - az * bz, aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw)


def conjugate(q):
    return (q[0], -q[1], -q[2], -q[3])


def rotate(q, v):
    return times(times(q, (0, *v)), conjugate(q))[1:]


def plus(a, b, by=1):
    return tuple(x + by * y for x, y in zip(a, b))


def about(axis, degrees):
    half = math.radians(degrees) / 2
    return (math.cos(half), *(math.sin(half) * x for x in axis))


IDENTITY = (1, 0, 0, 0)


class Log(list):
    """Lines of a log of commands."""

    def line(self, frame, command, **values):
        self.append((frame, command, values))

    def add(self, frame, name, colour, **values):
        """An object with its colour."""
        rounded = lambda v: [round(x, 5) for x in v] if isinstance(v, (list, tuple)) else v
        self.line(frame, "add_object",
                  object={"name": name, **{k: rounded(v) for k, v in values.items()}})
        self.line(frame, "set_colour", objects=[name], colour=colour)

    def strand(self, frame, name, colour, points, per_frame=1, **values):
        """Clay from a nozzle along points; returns the frame after its end."""
        points = [[round(x, 5) for x in p] for p in points]
        self.line(frame, "source_begin", name=name, at=points[0], **values)
        for i, at in enumerate(points[1:]):
            self.line(frame + i // per_frame, "source_move", name=name, at=at)
        frame += (len(points) - 2) // per_frame
        self.line(frame, "source_end", name=name)
        self.line(frame, "set_colour", objects=[name], colour=colour)
        return frame + 1

    def write(self, name):
        self.sort(key=lambda line: line[0])
        with open(os.path.join(here, name + ".jsonl"), "w") as out:
            for frame, command, values in self:
                line = {"frame": frame, command: values}
                out.write(json.dumps(line, separators=(",", ":")) + "\n")


class Hand:
    """A hand that holds its shape and moves from key to key along paths of minimum jerk. `point` in
    the frame of `joint` is the part of hand or tool that the keys place."""

    def __init__(self, shape, joint, point):
        self.shape, self.joint, self.point, self.keys = shape, joint, point, []

    def at(self, time, place, turn=IDENTITY):
        self.keys.append((time, place, turn))
        return self

    def pose(self, time, zoom):
        keys = self.keys
        i = 0
        while i + 2 < len(keys) and keys[i + 1][0] <= time:
            i += 1
        (t0, p0, q0), (t1, p1, q1) = keys[i], keys[i + 1]
        s = min(max((time - t0) / (t1 - t0), 0), 1)
        s = s**3 * (10 - 15 * s + 6 * s * s)
        place = plus(p0, plus(p1, p0, -1), s)
        if sum(a * b for a, b in zip(q0, q1)) < 0:
            q1 = tuple(-x for x in q1)
        turn = plus(q0, plus(q1, q0, -1), s)
        turn = tuple(x / math.sqrt(sum(y * y for y in turn)) for x in turn)
        # The joint gets the orientation `turn`, and all others move with it as a rigid body.
        own = self.shape[self.joint]
        whole = times(turn, conjugate(own[3:7]))
        origin = plus(tuple(x / zoom for x in place), rotate(turn, self.point), -1)
        joints = []
        for joint in self.shape:
            p = plus(origin, rotate(whole, plus(joint[:3], own[:3], -1)))
            q = times(whole, joint[3:7])
            q = tuple(x / math.sqrt(sum(y * y for y in q)) for x in q)
            joints.append([*(round(x, 7) for x in p), *(round(x, 8) for x in q), *joint[7:]])
        return {"tracked": True, "joints": joints}


def shapes(program):
    """The right and the left hand of a generated gesture, flat under a tool."""
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "roll.jsonl")
        subprocess.run([program, "record", "roll", file, "-q"], check=True)
        with open(file) as lines:
            lines.readline()
            frame = json.loads(lines.readline())
    return {side: frame[side]["joints"] for side in ("left", "right")}


def record(program, name, zoom, seconds, left=None, right=None, rate=30):
    """Writes NAME.hands: hands of a scene with this `zoom` and "at": [0, 0, 0]."""
    frames = int(seconds * rate) + 1
    none = {"tracked": False, "joints": [[0] * 9] * 26}
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, name + ".jsonl")
        with open(file, "w") as out:
            head = {"format": "knead.hands/1", "name": name, "rate": rate, "latency": 0,
                    "frames": frames}
            out.write(json.dumps(head) + "\n")
            for i in range(frames):
                time = i / rate
                hands = {side: hand.pose(time, zoom) if hand else none
                         for side, hand in (("left", left), ("right", right))}
                out.write(json.dumps({"time": time, **hands}) + "\n")
        to = os.path.join(here, name + ".hands")
        subprocess.run([program, "convert", file, to, "--overwrite", "-q"], check=True)


WHITE, COAL, CARROT = [0.93, 0.95, 0.98], [0.1, 0.1, 0.11], [0.95, 0.45, 0.1]
RED, TWIG, FELT = [0.75, 0.1, 0.12], [0.36, 0.23, 0.13], [0.13, 0.13, 0.17]


def snowman(program):
    """Balls of snow that weld get dents of a stylus, then coal, a carrot, arms and a hat that lay
    on the floor. Commands that add clay come before the first frame, and the others only move it: a
    session holds a step that adds particles as both states whole, others as a difference."""
    zoom, floor, x, z = 1.8, 0.05, 0.3, 0.3
    snow = {"preset": "snow", "density": 400, "young": 4e4, "compress": 0.05, "stretch": 0.04,
            "snow": 2}
    light = {"preset": "clay", "young": 3e4, "yield": 6e3, "density": 400}
    radius = {"foot": 0.12, "belly": 0.092, "head": 0.07}
    sunk = 0.03  # each ball into the one below it, where the lower one keeps its snow
    log = Log()
    log.line(0, "mark", text="three balls of snow: one category, so they weld")
    y = floor
    for name, r in radius.items():
        log.add(0, name, WHITE, centre=(x, y + r, z), diameter=2 * r, material=snow)
        y += 2 * r - sunk
    # Where their weight will have brought the balls when the commands after the hands come.
    place = {name: (x, floor + y, z)
             for name, y in (("foot", 0.096), ("belly", 0.26), ("head", 0.388))}
    wide = {"belly": 0.089, "head": 0.064}

    log.line(0, "mark",
             text="coal, a carrot, twigs and a hat on the floor, a scarf around the neck")
    dents = {"left eye": ("head", -0.033, 0.022), "right eye": ("head", 0.033, 0.022),
             "button 1": ("belly", 0, 0.034), "button 2": ("belly", 0, -0.01),
             "button 3": ("belly", 0, -0.054)}
    # On the floor what will be above is behind; a quarter turn about x brings it into the front.
    lies = {"head": (0.64, 0.16), "belly": (0.72, 0.2)}
    for name, (ball, across, up) in dents.items():
        lx, lz = lies[ball]
        coal = 0.042 if ball == "head" else 0.036
        log.add(0, name, COAL, centre=(lx + across, floor + coal / 2, lz - up), diameter=coal,
                material=light, category=1)
    carrot = 0.09
    log.add(0, "nose", CARROT, shape="cone", centre=(0.82, floor + carrot / 2, 0.17), diameter=0.04,
            height=carrot, material=light, category=2)
    tall, y = {"brim": 0.026, "band": 0.026, "crown": 0.045}, floor
    for name, colour, diameter in (("brim", FELT, 0.16), ("band", RED, 0.105),
                                   ("crown", FELT, 0.105)):
        log.add(0, name, colour, shape="cylinder", centre=(0.7, y + tall[name] / 2, 0.38),
                diameter=diameter, height=tall[name], material=light, category=5)
        y += tall[name]
    neck = floor + 0.24 + 0.184 - 1.5 * sunk
    turn = [(x + 0.066 * math.sin(a), neck, z + 0.066 * math.cos(a))
            for a in (2 * math.pi * i / 20 for i in range(21))]
    turn += [(x + 0.055, neck - 0.026 - 0.02 * i, z + 0.088 + 0.004 * i) for i in range(2)]
    log.strand(0, "scarf", RED, turn, 100, diameter=0.038, material=light, category=3)
    twig = [(0.6 + 0.02 * i, floor + 0.017, 0.1) for i in range(6)]
    for name, lz in (("left arm", 0.08), ("right arm", 0.47)):
        log.strand(0, name, TWIG, [(px, py, lz) for px, py, _ in twig], 100, diameter=0.032,
                   material={**light, "density": 150}, category=4)

    # A stylus, a ball of 8 mm radius, 1.8 times as large here, presses from the front; another one
    # supports the snow from the opposite side, so that the stack does not lean.
    tip, deep, time = 0.008 * zoom, 0.027, 0.35
    pen, other = (Hand(shapes(program)[side], INDEX, (0, -0.01, -0.07))
                  for side in ("right", "left"))
    for ball, across, up in dents.values():
        sx, sy, sz = plus(place[ball], (across, up, math.sqrt(wide[ball]**2 - across**2 - up**2)))
        before, within = (sx, sy, sz + tip + 0.015), (sx, sy, sz + tip - deep)
        if not pen.keys:
            pen.at(0, plus(before, (0, 0, 0.15)))
        pen.at(time, before).at(time + 0.12, within).at(time + 0.24, before)
        time += 0.24 + 0.12
    pen.at(time + 0.1, (x, 0.5, z + 0.4))
    for at, (px, py, pz), _ in pen.keys:
        other.at(at, (2 * x - px, py, 2 * z - pz), about((0, 1, 0), 180))
    record(program, "snowman", zoom, time + 0.1, left=other, right=pen)

    def move(names, was, to, turn, **more):
        """From a point on the floor to one of the snowman."""
        log.line(frame, "move_objects", objects=names, by=[round(v, 5) for v in plus(to, was, -1)],
                 turn=[round(v, 7) for v in turn], about=[round(v, 5) for v in was], **more)

    frame = int(60 * (time + 0.1)) + 2
    log.line(frame, "mark", text="coal, the carrot, twigs and the hat are moved")
    upright = about((1, 0, 0), 90)
    for ball, back in (("head", 0.055), ("belly", 0.0885)):
        names = [name for name, dent in dents.items() if dent[0] == ball]
        move(names, (lies[ball][0], floor, lies[ball][1]), plus(place[ball], (0, 0, back)), upright)
    move(["nose"], (0.82, floor, 0.17),
         plus(place["head"], (0, -0.014, wide["head"] + 0.009)), upright)
    for name, lz, side, angle in (("left arm", 0.08, -1, 135), ("right arm", 0.47, 1, 45)):
        move([name], (*twig[0][:2], lz),
             plus(place["belly"], (side * (wide["belly"] + 0.0125), 0, 0)),
             about((0, 0, 1), angle))
    move(["brim", "band", "crown"], (0.7, floor, 0.38),
         plus(place["head"], (0, wide["head"] + 0.006, 0)), IDENTITY)
    frame += 36
    log.line(frame, "mark", text="five steps back and forth")
    for command in ["undo"] * 5 + ["redo"] * 5:
        log.line(frame, command)
    log.line(frame + 4, "save", file="snowman.knead")
    log.write("snowman")
    print("snowman:", frame, "undo")


BUN, MEAT, CHEESE = [0.87, 0.6, 0.28], [0.33, 0.17, 0.1], [1.0, 0.75, 0.15]
TOMATO, LETTUCE, SEED = [0.8, 0.13, 0.08], [0.35, 0.65, 0.15], [0.97, 0.91, 0.75]


def hamburger(program):
    """Layers of four categories that do not stick, flattened and pressed by a board."""
    zoom, floor, x, z = 1.6, 0.04, 0.22, 0.22
    bread = {"preset": "dough", "density": 400, "young": 2e4, "yield": 1500}
    meat = {"preset": "clay", "density": 900, "young": 4e4, "yield": 1500}
    soft = {"preset": "jelly", "density": 900, "young": 2e4}
    log = Log()
    # Category by category that touches: bread 0, meat and tomato 1, cheese 2, lettuce 3.
    log.line(0, "mark", text="a bun and a ball of meat")
    log.add(0, "lower bun", BUN, shape="cylinder", centre=(x, floor + 0.02, z), diameter=0.2,
            height=0.036, material=bread, category=0)
    log.add(0, "patty", MEAT, shape="ellipsoid", centre=(x, floor + 0.075, z),
            size=[0.16, 0.06, 0.16], material=meat, category=1)

    # The board: a slab of 90 x 130 mm, 1.6 times as large here, its face 35 mm below the palm.
    board = Hand(shapes(program)["right"], PALM, (0, -0.035, -0.05))
    board.at(0, (x, 0.3, z)).at(0.3, (x, 0.16, z)).at(0.7, (x, floor + 0.036 + 0.032, z))
    board.at(1.0, (x, 0.19, z)).at(1.15, (x + 0.2, 0.3, z)).at(1.45, (x + 0.2, 0.3, z))
    board.at(1.65, (x, 0.25, z)).at(1.95, (x, 0.193, z)).at(2.2, (x, 0.25, z))
    board.at(2.4, (x + 0.2, 0.34, z))
    record(program, "hamburger", zoom, 2.4, right=board)

    frame, y = 72, floor + 0.072
    log.line(frame, "mark", text="cheese, tomato, lettuce and the upper bun fall on it")
    log.add(frame, "cheese", CHEESE, shape="box", centre=(x, y + 0.008, z),
            size=[0.19, 0.014, 0.19], material=soft, category=2)
    y += 0.022
    for i, (dx, dz) in enumerate(((-0.042, 0.03), (0.042, 0.03), (0, -0.045))):
        log.add(frame, f"tomato {i + 1}", TOMATO, shape="cylinder",
                centre=(x + dx, y + 0.008, z + dz), diameter=0.078, height=0.016,
                material=soft, category=1)
    y += 0.022
    log.add(frame, "lettuce", LETTUCE, shape="cylinder", centre=(x, y + 0.008, z), diameter=0.2,
            height=0.014, material=soft, category=3)
    y += 0.022
    log.add(frame, "upper bun", BUN, shape="ellipsoid", centre=(x, y + 0.044, z),
            size=[0.2, 0.08, 0.2], material=bread, category=0)
    for i in range(12):
        # Seeds over the bun by the golden angle; the bun keeps what is in it.
        r, a = 0.82 * math.sqrt((i + 0.5) / 12), 2.39996 * i
        seed = (x + 0.1 * r * math.cos(a), y + 0.044 + 0.04 * math.sqrt(1 - r * r) + 0.004,
                z + 0.1 * r * math.sin(a))
        log.add(frame, f"seed {i + 1}", SEED, shape="ellipsoid", centre=seed,
                size=[0.016, 0.012, 0.016], material=bread, category=0)
    log.line(142, "mark", text="pressed, the upper bun comes off")
    bun = ["upper bun"] + [f"seed {i + 1}" for i in range(12)]
    log.line(142, "move_objects", objects=bun, by=[0, 0.06, 0])
    log.line(148, "undo")
    log.line(150, "save", file="hamburger.knead")
    log.write("hamburger")
    print("hamburger: 150 frames")


def main():
    program, *names = sys.argv[1:]
    studies = {"snowman": snowman, "hamburger": hamburger}
    for name in names or studies:
        studies[name](program)


main()
