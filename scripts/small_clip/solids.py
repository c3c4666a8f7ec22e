# SPDX-License-Identifier: BSD-3-Clause
"""Solids as unions of signed distances, and buffers of how they look from
random viewpoints: position, normal and part of each pixel, without colour."""
import numpy as np

# Parts of a solid. MAIN has the colour and material of the caption.
MAIN, PAGES, STEM, LEAF, BAND, DARK, WOOD, GLASS, MUZZLE = range(9)


def sphere(c, r):
    return lambda x, y, z: np.sqrt(
        (x - c[0]) ** 2 + (y - c[1]) ** 2 + (z - c[2]) ** 2) - r


def ellipsoid(c, r):
    return lambda x, y, z: (np.sqrt(
        ((x - c[0]) / r[0]) ** 2 + ((y - c[1]) / r[1]) ** 2 +
        ((z - c[2]) / r[2]) ** 2) - 1) * min(r)


def box(c, h, rounding=0.02):
    def distance(x, y, z):
        qx = np.abs(x - c[0]) - h[0] + rounding
        qy = np.abs(y - c[1]) - h[1] + rounding
        qz = np.abs(z - c[2]) - h[2] + rounding
        outside = np.sqrt(np.maximum(qx, 0) ** 2 + np.maximum(qy, 0) ** 2 +
                          np.maximum(qz, 0) ** 2)
        return outside + np.minimum(
            np.maximum(qx, np.maximum(qy, qz)), 0) - rounding
    return distance


def frustum(y0, r0, y1, r1, c=(0, 0), axis=1):
    """A cone, cut off, or a cylinder, along an axis."""
    slope = 1 / np.sqrt(1 + ((r1 - r0) / (y1 - y0)) ** 2)
    middle, half = (y0 + y1) / 2, abs(y1 - y0) / 2

    def distance(*p):
        a, b = (p[i] for i in range(3) if i != axis)
        y = p[axis]
        radius = r0 + (r1 - r0) * (y - y0) / (y1 - y0)
        side = (np.sqrt((a - c[0]) ** 2 + (b - c[1]) ** 2) - radius) * slope
        return np.maximum(side, np.abs(y - middle) - half)
    return distance


def capsule(a, b, r):
    a, b = np.array(a, np.float32), np.array(b, np.float32)
    d = b - a
    inverse = 1 / (d @ d)

    def distance(x, y, z):
        t = ((x - a[0]) * d[0] + (y - a[1]) * d[1] +
             (z - a[2]) * d[2]) * inverse
        t = np.clip(t, 0, 1)
        return np.sqrt((x - a[0] - t * d[0]) ** 2 +
                       (y - a[1] - t * d[1]) ** 2 +
                       (z - a[2] - t * d[2]) ** 2) - r
    return distance


def torus(c, big, small, axis=1):
    def distance(*p):
        q = [p[i] - c[i] for i in range(3)]
        a, b = (q[i] for i in range(3) if i != axis)
        return np.sqrt((np.sqrt(a * a + b * b) - big) ** 2 +
                       q[axis] ** 2) - small
    return distance


def revolved(ys, rs):
    """A surface of revolution about y with the radii `rs` at `ys`."""
    def distance(x, y, z):
        side = (np.sqrt(x * x + z * z) - np.interp(y, ys, rs)) * 0.6
        return np.maximum(side, np.maximum(ys[0] - y, y - ys[-1]))
    return distance


def without(solid, hole):
    return lambda x, y, z: np.maximum(solid(x, y, z), -hole(x, y, z))


def smooth_profile(rng, ys, rs, jitter=0.05):
    fine = np.linspace(ys[0], ys[-1], 40)
    rs = np.array(rs) * (1 + rng.uniform(-jitter, jitter, len(rs)))
    values = np.interp(fine, ys, rs)
    for _ in range(6):
        values[1:-1] = (values[:-2] + values[1:-1] + values[2:]) / 3
    return fine, values


def make_ball(rng):
    return [(MAIN, sphere((0, 0, 0), 0.9))]


def make_box(rng):
    h = rng.uniform(0.4, 0.85, 3) if rng.random() < 0.7 else np.full(3, 0.65)
    return [(MAIN, box((0, 0, 0), h, rng.uniform(0.0, 0.05)))]


def make_crate(rng):
    h = rng.uniform(0.45, 0.75, 3)
    parts = [(MAIN, box((0, 0, 0), h))]
    for sx in (-1, 1):
        for sz in (-1, 1):
            parts.append((MAIN, box((sx * h[0], 0, sz * h[2]),
                                    (0.07, h[1] + 0.04, 0.07))))
    for sy in (-1, 1):
        for s in (-1, 1):
            parts.append((MAIN, box((0, sy * h[1], s * h[2]),
                                    (h[0] + 0.04, 0.06, 0.06))))
    return parts


def make_cylinder(rng):
    h, r = rng.uniform(0.4, 0.9), rng.uniform(0.35, 0.6)
    return [(MAIN, frustum(-h, r, h, r))]


def make_cone(rng):
    h = rng.uniform(0.6, 0.9)
    return [(MAIN, frustum(-h, rng.uniform(0.5, 0.75), h, 0.02))]


def make_capsule(rng):
    h = rng.uniform(0.35, 0.55)
    return [(MAIN, capsule((0, -h, 0), (0, h, 0), rng.uniform(0.28, 0.42)))]


def make_torus(rng):
    small = rng.uniform(0.16, 0.3)
    return [(MAIN, torus((0, 0, 0), 0.9 - small, small))]


def make_mug(rng):
    h, r = rng.uniform(0.5, 0.75), rng.uniform(0.45, 0.6)
    top = r * rng.uniform(0.95, 1.1)
    cup = without(frustum(-h, r, h, top),
                  frustum(-h + 0.1, r - 0.08, h + 0.5, top - 0.08))
    ring = torus((r + 0.08, 0, 0), rng.uniform(0.25, 0.34), 0.075, 2)
    return [(MAIN, cup),
            (MAIN, without(ring, frustum(-2, r - 0.04, 2, r - 0.04)))]


def make_vase(rng):
    ys = [-0.95, -0.8, -0.2, 0.3, 0.6, 0.8, 0.95]
    kinds = [[0.3, 0.36, 0.58, 0.5, 0.26, 0.28, 0.36],
             [0.25, 0.3, 0.45, 0.55, 0.35, 0.2, 0.26],
             [0.35, 0.5, 0.6, 0.4, 0.22, 0.22, 0.3],
             [0.3, 0.3, 0.36, 0.42, 0.4, 0.38, 0.42]]
    fine, radii = smooth_profile(rng, ys, kinds[rng.integers(4)], 0.12)
    hole = frustum(0.3, radii[-8] - 0.08, 1.5, radii[-1] - 0.01)
    return [(MAIN, without(revolved(fine, radii), hole))]


def make_bottle(rng):
    neck = rng.uniform(0.1, 0.15)
    ys = [-0.95, 0.15, 0.45, 0.9]
    fine, radii = smooth_profile(rng, ys, [0.33, 0.33, neck, neck], 0.1)
    return [(MAIN, revolved(fine, radii)),
            (DARK, frustum(0.85, neck + 0.03, 1.0, neck + 0.03))]


def make_bowl(rng):
    ys = np.linspace(-0.5, 0.25, 20)
    radii = np.sqrt(np.maximum(0.85 ** 2 - (ys - 0.3) ** 2, 0.01)) * 1.05
    return [(MAIN, without(revolved(ys, radii), sphere((0, 0.32, 0), 0.78)))]


def make_plate(rng):
    disc = frustum(-0.08, 0.55, 0.06, 0.95)
    return [(MAIN, without(disc, frustum(-0.03, 0.5, 0.2, 0.98)))]


def make_book(rng):
    h = rng.uniform(0.08, 0.2)
    w, d = rng.uniform(0.5, 0.7), rng.uniform(0.7, 0.9)
    return [(MAIN, box((0, h, 0), (w, 0.03, d), 0.01)),
            (MAIN, box((0, -h, 0), (w, 0.03, d), 0.01)),
            (MAIN, box((-w, 0, 0), (0.03, h + 0.03, d), 0.01)),
            (PAGES, box((-0.02, 0, 0), (w - 0.05, h, d - 0.05), 0))]


def make_apple(rng):
    squash = rng.uniform(0.85, 1.0)

    def body(x, y, z):
        rho = np.sqrt(x * x + z * z)
        base = np.sqrt((np.abs(rho - 0.22)) ** 2 + (y / squash) ** 2) - 0.6
        taper = 0.12 * (y + 0.6) - 0.06
        return np.maximum((base - taper) * 0.7,
                          -(np.sqrt(rho ** 2 + (y - 0.72) ** 2) - 0.2) * 0.7)
    parts = [(MAIN, body), (STEM, capsule((0, 0.4, 0), (0.06, 0.8, 0), 0.04))]
    if rng.random() < 0.6:
        parts.append((LEAF, ellipsoid((0.2, 0.7, 0.03), (0.18, 0.04, 0.09))))
    return parts


def legs(rng, top, spread, count, radius, part, bottom=-0.95):
    parts = []
    turn = np.pi / 4
    for i in range(count):
        a = turn + 2 * np.pi * i / count
        s, c = np.sin(a), np.cos(a)
        parts.append((part, capsule(
            (top[0] * c, top[1], top[0] * s),
            (spread * c, bottom, spread * s), radius)))
    return parts


def make_stool(rng):
    r, y = rng.uniform(0.45, 0.65), rng.uniform(0.2, 0.6)
    part = WOOD if rng.random() < 0.6 else MAIN
    seat = frustum(y, r, y + rng.uniform(0.1, 0.22), r)
    spread = r * rng.uniform(0.8, 1.1)
    parts = [(MAIN, seat)] + legs(rng, (r * 0.65, y), spread,
                                  int(rng.integers(3, 5)), 0.06, part)
    if rng.random() < 0.6:
        parts.append((part, torus((0, -0.45, 0), spread * 0.85, 0.035)))
    return parts


def make_chair(rng):
    w, y, top = rng.uniform(0.36, 0.46), rng.uniform(-0.15, 0.0), 0.95
    t = 0.05
    parts = [(MAIN, box((0, y, 0), (w, 0.05, w)))]
    for sx in (-1, 1):
        x = sx * (w - t)
        parts.append((MAIN, box((x, (y - 0.95) / 2, w - t),
                                (t, (y + 0.95) / 2, t))))
        parts.append((MAIN, box((x, 0, -w + t), (t, top, t))))
        if rng.random() < 0.6:
            parts.append((MAIN, box((x, -0.5, 0), (0.03, 0.03, w))))
    if rng.random() < 0.7:
        for i in range(int(rng.integers(2, 4))):
            parts.append((MAIN, box((0, top - 0.12 - 0.27 * i, -w + t),
                                    (w, 0.08, 0.03))))
    else:
        parts.append((MAIN, box((0, 0.6, -w + t), (w, 0.3, 0.03))))
    return parts


def make_table(rng):
    w, d, y = rng.uniform(0.7, 0.95), rng.uniform(0.45, 0.7), 0.4
    round_top = rng.random() < 0.25
    top = frustum(y, d, y + 0.08, d) if round_top else box(
        (0, y + 0.04, 0), (w, 0.05, d))
    parts = [(MAIN, top)]
    if round_top:
        return parts + legs(rng, (d * 0.7, y), d * 0.75, 4, 0.05, MAIN, -0.6)
    for sx in (-1, 1):
        for sz in (-1, 1):
            parts.append((MAIN, box((sx * (w - 0.08), -0.1,
                                     sz * (d - 0.08)), (0.05, 0.5, 0.05))))
    return parts


def make_car(rng):
    l, w = rng.uniform(0.75, 0.9), rng.uniform(0.36, 0.46)
    cabin = rng.uniform(-0.25, 0.1)
    r = rng.uniform(0.17, 0.25)
    parts = [(MAIN, box((0, -0.05, 0), (l, 0.2, w), 0.07)),
             (MAIN, box((cabin, 0.3, 0), (l * 0.45, 0.22, w * 0.85), 0.06)),
             (GLASS, box((cabin, 0.3, 0), (l * 0.36, 0.13, w * 0.87), 0.02)),
             (GLASS, box((cabin, 0.3, 0), (l * 0.46, 0.13, w * 0.7), 0.02))]
    for sx in (-1, 1):
        for s in (-1, 1):
            x = sx * l * 0.6
            wheel = frustum(s * w - 0.09, r, s * w + 0.09, r, (x, -0.22), 2)
            hub = frustum(s * w - 0.1, r * 0.4, s * w + 0.1, r * 0.4,
                          (x, -0.22), 2)
            parts += [(DARK, wheel), (BAND, hub)]
    return parts


def make_traffic_cone(rng):
    top, bottom, low = 0.06, rng.uniform(0.38, 0.5), -0.85

    def radius(y):
        return bottom + (top - bottom) * (y - low) / (0.95 - low)
    parts = [(MAIN, box((0, low - 0.05, 0), (0.62, 0.06, 0.62), 0.03)),
             (MAIN, frustum(low, bottom, 0.95, top))]
    count = int(rng.integers(1, 3))
    for i in range(count):
        a = -0.45 + 0.7 * i + rng.uniform(-0.1, 0.1)
        b = a + rng.uniform(0.22, 0.35)
        parts.append((BAND, frustum(a, radius(a) + 0.012,
                                    b, radius(b) + 0.012)))
    return parts


def make_bear(rng):
    sit = rng.uniform(0, 0.12)
    parts = [(MAIN, ellipsoid((0, -0.2, 0), (0.38, 0.44, 0.34))),
             (MAIN, sphere((0, 0.45, 0.03), 0.33)),
             (MUZZLE, ellipsoid((0, 0.38, 0.32), (0.15, 0.12, 0.12))),
             (DARK, sphere((0, 0.43, 0.43), 0.05))]
    if rng.random() < 0.6:
        parts.append((MUZZLE, ellipsoid((0, -0.2, 0.2), (0.2, 0.26, 0.17))))
    for s in (-1, 1):
        parts += [(MAIN, sphere((s * 0.26, 0.74, 0), 0.13)),
                  (MUZZLE, sphere((s * 0.26, 0.74, 0.08), 0.075)),
                  (DARK, sphere((s * 0.12, 0.53, 0.31), 0.045)),
                  (MAIN, capsule((s * 0.3, 0.05, 0.05),
                                 (s * 0.5, -0.2 + sit, 0.35), 0.12)),
                  (MAIN, capsule((s * 0.2, -0.5, 0.1),
                                 (s * 0.4, -0.55, 0.62), 0.15)),
                  (MUZZLE, sphere((s * 0.42, -0.55, 0.7), 0.1))]
    return parts


def make_monkey(rng):
    """An animal's head: brows, muzzle, wide ears, eyes."""
    w = rng.uniform(0.5, 0.6)
    parts = [(MAIN, ellipsoid((0, 0.15, -0.05), (w, 0.52, 0.5))),
             (MAIN, ellipsoid((0, -0.3, 0.25), (0.36, 0.3, 0.3))),
             (MAIN, capsule((-0.25, 0.3, 0.4), (0.25, 0.3, 0.4), 0.13)),
             (MAIN, sphere((0, -0.1, 0.5), 0.08))]
    dark = DARK if rng.random() < 0.7 else MAIN
    for s in (-1, 1):
        ear = without(ellipsoid((s * 0.78, 0.12, -0.1), (0.28, 0.3, 0.09)),
                      ellipsoid((s * 0.78, 0.12, 0.02), (0.19, 0.2, 0.09)))
        parts += [(MAIN, ear), (dark, sphere((s * 0.2, 0.18, 0.47), 0.1))]
    return parts


def make_lamp(rng):
    r = rng.uniform(0.4, 0.6)
    return [(MAIN, without(frustum(0.15, r, 0.85, r * 0.6),
                           frustum(0.1, r - 0.05, 0.9, r * 0.6 - 0.05))),
            (DARK, frustum(-0.85, 0.05, 0.6, 0.05)),
            (DARK, frustum(-0.95, 0.35, -0.85, 0.3))]


def flat(outline):
    """A plane figure as a thin slab; `outline` is a distance in x and y."""
    return lambda x, y, z: np.maximum(outline(x, y) * 0.5, np.abs(z) - 0.03)


def polygon_star(x, y, points, inner):
    angle = np.arctan2(x, y) * points / (2 * np.pi)
    t = np.abs(angle - np.round(angle)) * 2
    return np.hypot(x, y) - 1 / ((1 - t) / 0.9 + t / inner)


def make_flat(outline):
    return lambda rng: [(MAIN, flat(outline))]


def triangle(x, y):
    return np.maximum(np.abs(x) * 0.87 + y * 0.5, -y) - 0.45


def heart(x, y):
    y = y + 0.1
    return (np.hypot(np.abs(x) * 1.05, y - np.abs(x) * 0.75) - 0.7)


def cross(x, y):
    a, b = np.abs(x), np.abs(y)
    return np.minimum(np.maximum(a - 0.27, b - 0.85),
                      np.maximum(a - 0.85, b - 0.27))


FLAT = {
    "circle": lambda x, y: np.hypot(x, y) - 0.85,
    "square": lambda x, y: np.maximum(np.abs(x), np.abs(y)) - 0.7,
    "triangle": triangle,
    "star": lambda x, y: polygon_star(x, y, 5, 0.38),
    "heart": heart,
    "ring": lambda x, y: np.abs(np.hypot(x, y) - 0.68) - 0.17,
    "cross": cross,
}

SOLIDS = {
    "ball": make_ball, "box": make_box, "cylinder": make_cylinder,
    "cone": make_cone, "capsule": make_capsule, "donut": make_torus,
    "mug": make_mug, "vase": make_vase, "bottle": make_bottle,
    "bowl": make_bowl, "plate": make_plate, "book": make_book,
    "apple": make_apple, "stool": make_stool, "chair": make_chair,
    "table": make_table, "toy car": make_car,
    "traffic cone": make_traffic_cone, "teddy bear": make_bear,
    "monkey": make_monkey, "lamp": make_lamp,
    **{name: make_flat(outline) for name, outline in FLAT.items()},
}
SHAPES = list(SOLIDS)


def random_camera(rng, name):
    """Rotation from the solid's axes to the camera's (x right, y up, z to the
    viewer)."""
    if name in FLAT:
        yaw, pitch = rng.uniform(-0.7, 0.7), rng.uniform(-0.5, 0.6)
        roll = rng.uniform(-np.pi, np.pi) if rng.random() < 0.3 else (
            rng.normal(0, 0.15))
    else:
        yaw, roll = rng.uniform(-np.pi, np.pi), rng.normal(0, 0.06)
        pitch = rng.uniform(0.05, 1.0)
        if rng.random() < 0.1:
            pitch, roll = rng.uniform(-1, 1.4), rng.uniform(-np.pi, np.pi)
    cy, sy, cp, sp = np.cos(yaw), np.sin(yaw), np.cos(pitch), np.sin(pitch)
    cr, sr = np.cos(roll), np.sin(roll)
    turn = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    tilt = np.array([[1, 0, 0], [0, cp, -sp], [0, sp, cp]])
    spin = np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
    return (spin @ tilt @ turn).astype(np.float32)


def distance_of(parts, p):
    result = parts[0][1](*p)
    for _, solid in parts[1:]:
        np.minimum(result, solid(*p), out=result)
    return result


def render(parts, rotation, size, distance=4.0, steps=40):
    """(positions, normals, parts + 1) on a size x size grid, by sphere
    tracing; parts are 0 where nothing is."""
    line = (np.arange(size, dtype=np.float32) + 0.5) / size * 2 - 1
    u, v = np.meshgrid(line * 1.42, -line * 1.42)
    rays = np.stack([u, v, np.full_like(u, -distance)], -1).reshape(-1, 3)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    rays = rays @ rotation
    origin = np.array([0, 0, distance], np.float32) @ rotation
    along = -(rays @ origin)
    near = np.sum((origin + rays * along[:, None]) ** 2, 1) < 1.45 ** 2
    live = np.flatnonzero(near)
    t = along - 1.5
    hit = np.zeros(len(rays), bool)
    for _ in range(steps):
        d = distance_of(parts, (origin + rays[live] * t[live, None]).T)
        t[live] += d
        done = d < 0.004
        hit[live[done]] = True
        live = live[~done & (t[live] < along[live] + 1.5)]
        if not len(live):
            break
    points = origin + rays[hit] * t[hit, None]
    normals = np.zeros_like(points)
    for k in ((1, -1, -1), (-1, -1, 1), (-1, 1, -1), (1, 1, 1)):
        k = np.array(k, np.float32)
        normals += k * distance_of(parts, (points + 0.004 * k).T)[:, None]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-9
    each = np.stack([solid(*points.T) for _, solid in parts])
    names = np.array([part for part, _ in parts], np.uint8)
    position = np.zeros((size * size, 3), np.float16)
    normal = np.zeros((size * size, 3), np.int8)
    part = np.zeros(size * size, np.uint8)
    position[hit], part[hit] = points, names[each.argmin(0)] + 1
    normal[hit] = np.round(normals * 127)
    shape = (size, size)
    return (position.reshape(*shape, 3), normal.reshape(*shape, 3),
            part.reshape(shape))


def views_of(name, seed, count, size):
    """`count` buffers of one shape; each of another size and viewpoint."""
    result = []
    for i in range(count):
        rng = np.random.default_rng((seed, SHAPES.index(name), i))
        make = SOLIDS[name]
        if name == "box" and rng.random() < 0.35:
            make = make_crate
        rotation = random_camera(rng, name)
        position, normal, part = render(make(rng), rotation, size)
        rows, columns = part.any(1).nonzero()[0], part.any(0).nonzero()[0]
        window = np.s_[rows[0]:rows[-1] + 1, columns[0]:columns[-1] + 1]
        result.append((position[window], normal[window], part[window],
                       rotation))
    return result
