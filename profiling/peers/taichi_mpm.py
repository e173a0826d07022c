#!/usr/bin/env python3
"""The paper's algorithm [VR-Doh 2025] in the paper's language, written anew: MLS-MPM on a dense
lattice, one kernel per stage, F stored, a singular value decomposition per particle and substep,
distance to all medial cones sampled on the lattice once a frame, particles projected.

usage: taichi_mpm.py SCENE.json POSITIONS.f32 cuda|cpu each-substep|each-frame
Both files are those that `knead bench --peers` writes. The last line says, in JSON, what a substep
took and where the clay is. each-frame: particles are projected once after a frame's
substeps, as the paper's program does; each-substep: as its text says.
Ends with 3 where Python has no taichi.
"""
import json
import sys
import time

try:
    import numpy as np
    import taichi as ti
except ImportError as missing:
    print(f"taichi_mpm.py: {missing}", file=sys.stderr)
    sys.exit(3)

if len(sys.argv) != 5 or sys.argv[3] not in ("cuda", "cpu"):
    print(__doc__, file=sys.stderr)
    sys.exit(2)
each_substep = sys.argv[4] == "each-substep"
with open(sys.argv[1]) as file:
    scene = json.load(file)
ti.init(arch=ti.cuda if sys.argv[3] == "cuda" else ti.cpu, default_fp=ti.f32)

n, count = scene["nodes"], scene["particles"]
dx, dt = scene["dx"], scene["dt"]
mu, lam = scene["mu"], scene["lambda"]
mass, volume = scene["mass"], scene["volume"]
bound = (2 / 3) ** 0.5 * scene["yield"] / (2 * mu)  # of the deviator of Hencky strain
margin, wall_friction = scene["margin"], scene["wall_friction"]
cone_count, sphere_count = len(scene["cones"]), len(scene["spheres"][0])
inv_dx = 1 / dx

x = ti.Vector.field(3, ti.f32, count)
v = ti.Vector.field(3, ti.f32, count)
C = ti.Matrix.field(3, 3, ti.f32, count)
F = ti.Matrix.field(3, 3, ti.f32, count)
node_v = ti.Vector.field(3, ti.f32, (n, n, n))
node_m = ti.field(ti.f32, (n, n, n))
node_phi = ti.field(ti.f32, (n, n, n))
node_normal = ti.Vector.field(3, ti.f32, (n, n, n))
node_speed = ti.Vector.field(3, ti.f32, (n, n, n))  # of the nearest cone's surface
node_cone = ti.field(ti.i32, (n, n, n))
cones = ti.Vector.field(2, ti.i32, cone_count)
sticky = ti.field(ti.i32, cone_count)
friction = ti.field(ti.f32, cone_count)
centre = ti.Vector.field(3, ti.f32, sphere_count)
speed = ti.Vector.field(3, ti.f32, sphere_count)
radius = ti.field(ti.f32, sphere_count)


@ti.func
def closest_point(k, p):
    """Distance to cone k, its outward normal, velocity of its axis there."""
    a, b = cones[k][0], cones[k][1]
    axis = centre[b] - centre[a]
    length = axis.norm()
    u = axis / length
    slope = (radius[b] - radius[a]) / length
    d = p - centre[a]
    along = d.dot(u)
    away = (d - along * u).norm()
    s = ti.math.clamp(along + slope / ti.sqrt(1 - slope * slope) * away, 0.0, length)
    out = d - s * u
    reach = ti.max(out.norm(), 1e-9)
    t = s / length
    return reach - radius[a] - slope * s, out / reach, (1 - t) * speed[a] + t * speed[b]


@ti.func
def nearest(p):
    phi, normal, u, at = 1e9, ti.Vector([0.0, 1.0, 0.0]), ti.Vector([0.0, 0.0, 0.0]), 0
    for k in range(cone_count):
        f, m, w = closest_point(k, p)
        if f < phi:
            phi, normal, u, at = f, m, w, k
    return phi, normal, u, at


@ti.func
def apply_contact(w, normal, u, at):
    """What a cone's surface leaves of the velocity w."""
    result = w
    rel = w - u
    vn = rel.dot(normal)
    if vn < 0:
        result = u
        if sticky[at] == 0:
            slide = rel - vn * normal
            size = slide.norm()
            left = size + friction[at] * vn
            if left > 0:
                result = u + slide * (left / size)
    return result


@ti.kernel
def sample_cones():
    for I in ti.grouped(node_phi):
        phi, normal, u, at = nearest(dx * I.cast(ti.f32))
        node_phi[I], node_normal[I], node_speed[I], node_cone[I] = phi, normal, u, at


@ti.kernel
def reset():
    for I in ti.grouped(node_m):
        node_v[I] = ti.Vector([0.0, 0.0, 0.0])
        node_m[I] = 0.0


@ti.kernel
def to_grid():
    for p in x:
        base = (x[p] * inv_dx - 0.5).cast(int)
        f = x[p] * inv_dx - base.cast(ti.f32)
        w = [0.5 * (1.5 - f) ** 2, 0.75 - (f - 1) ** 2, 0.5 * (f - 0.5) ** 2]
        F[p] = (ti.Matrix.identity(ti.f32, 3) + dt * C[p]) @ F[p]
        J = ti.max(F[p].determinant(), 1e-6)
        tau = mu * (F[p] @ F[p].transpose())
        for d in ti.static(range(3)):
            tau[d, d] += lam * ti.log(J) - mu
        affine = -dt * volume * 4 * inv_dx * inv_dx * tau + mass * C[p]
        for i, j, k in ti.static(ti.ndrange(3, 3, 3)):
            step = ti.Vector([i, j, k])
            weight = w[i][0] * w[j][1] * w[k][2]
            to = (step.cast(ti.f32) - f) * dx
            node_v[base + step] += weight * (mass * v[p] + affine @ to)
            node_m[base + step] += weight * mass


@ti.kernel
def on_grid(gx: ti.f32, gy: ti.f32, gz: ti.f32):
    for I in ti.grouped(node_m):
        if node_m[I] > 0:
            w = node_v[I] / node_m[I] + dt * ti.Vector([gx, gy, gz])
            if node_phi[I] < 0:
                w = apply_contact(w, node_normal[I], node_speed[I], node_cone[I])
            for d in ti.static(range(3)):
                into = 0.0
                if I[d] <= margin and w[d] < 0:
                    into = -w[d]
                if I[d] >= n - margin - 1 and w[d] > 0:
                    into = w[d]
                if into > 0:
                    w[d] = 0
                    size = w.norm()
                    w *= ti.max(0.0, 1 - wall_friction * into / ti.max(size, 1e-12))
            node_v[I] = w


@ti.kernel
def to_particles():
    for p in x:
        base = (x[p] * inv_dx - 0.5).cast(int)
        f = x[p] * inv_dx - base.cast(ti.f32)
        w = [0.5 * (1.5 - f) ** 2, 0.75 - (f - 1) ** 2, 0.5 * (f - 0.5) ** 2]
        new_v = ti.Vector.zero(ti.f32, 3)
        new_C = ti.Matrix.zero(ti.f32, 3, 3)
        for i, j, k in ti.static(ti.ndrange(3, 3, 3)):
            step = ti.Vector([i, j, k])
            weight = w[i][0] * w[j][1] * w[k][2]
            at = node_v[base + step]
            new_v += weight * at
            new_C += 4 * inv_dx * weight * at.outer_product(step.cast(ti.f32) - f)
        v[p] = new_v
        C[p] = new_C
        x[p] += dt * new_v


@ti.kernel
def project():
    low, high = dx * margin, dx * (n - 1 - margin)
    for p in x:
        phi, normal, u, at = nearest(x[p])
        if phi < 0:
            x[p] -= phi * normal
            v[p] = apply_contact(v[p], normal, u, at)
            C[p] = 0.5 * (C[p] - C[p].transpose())
        for d in ti.static(range(3)):
            x[p][d] = ti.math.clamp(x[p][d], low, high)


@ti.kernel
def apply_plasticity():
    for p in F:
        U, sigma, V = ti.svd(F[p])
        strain = ti.Vector([0.0, 0.0, 0.0])
        for d in ti.static(range(3)):
            strain[d] = ti.log(ti.max(ti.abs(sigma[d, d]), 1e-4))
        mean = strain.sum() / 3
        deviator = strain - mean
        size = deviator.norm()
        if size > bound:
            strain = mean + deviator * (bound / size)
        S = ti.Matrix.zero(ti.f32, 3, 3)
        for d in ti.static(range(3)):
            S[d, d] = ti.exp(strain[d])
        F[p] = U @ S @ V.transpose()


def main():
    x.from_numpy(np.fromfile(sys.argv[2], np.float32).reshape(count, 3))
    F.from_numpy(np.tile(np.eye(3, dtype=np.float32), (count, 1, 1)))
    cones.from_numpy(np.array(scene["cones"], np.int32))
    sticky.from_numpy(np.array([t["sticky"] for t in scene["contact_mode"]], np.int32))
    friction.from_numpy(np.array([t["friction"] for t in scene["contact_mode"]], np.float32))
    spheres = np.array(scene["spheres"], np.float32)
    radius.from_numpy(np.ascontiguousarray(spheres[0, :, 3]))
    substeps, times = scene["substeps"], []
    for frame in range(scene["frames"]):
        now, before = spheres[frame + 1, :, :3], spheres[frame, :, :3]
        ti.sync()
        start = time.perf_counter()
        centre.from_numpy(np.ascontiguousarray(now))
        speed.from_numpy(np.ascontiguousarray((now - before) / np.float32(dt * substeps)))
        sample_cones()
        for _ in range(substeps):
            reset()
            to_grid()
            on_grid(*scene["gravity"])
            to_particles()
            if each_substep:
                project()
            apply_plasticity()
        if not each_substep:
            project()
        ti.sync()
        if frame >= scene["warm_frames"]:
            times.append((time.perf_counter() - start) / substeps)
    places = x.to_numpy().astype(np.float64)
    print(json.dumps({
        "peer": "taichi " + ".".join(map(str, ti.__version__)),
        "arch": sys.argv[3], "projection": sys.argv[4], "particles": count, "frames": len(times),
        "substep_us": 1e6 * float(np.median(times)),
        "p95_us": 1e6 * float(np.percentile(times, 95)),
        "centre": places.mean(axis=0).tolist(), "extent": places.std(axis=0).tolist()}))


main()
