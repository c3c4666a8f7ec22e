#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""How far the cameras of a COLMAP model are from where they should be.

  bench/camera_poses.py MODEL TRUTH

MODEL is a folder with images.bin or images.txt. TRUTH is another such folder,
a gt/cameras.json of the scene maker, or a transforms.json of instant-ngp or
nerfstudio. The similarity that best maps camera centres onto the truth's comes
first (Umeyama 1991), as in sfm/scene/pose_alignment.h and `freegs_pipeline eval`;
then rotations are compared in degrees, and centres as a share of the scene's
size: the largest distance of a true camera from the mean of all.
"""
import argparse
import json
import math
import os
import statistics
import struct
import sys
from pathlib import Path

# A camera this far off is misplaced: part of a double, or of another scene.
MISPLACED_DEG = 5.0
MISPLACED_SHARE = 0.05

# Centres lie on a line when their spread across it is below this share.
MIN_SPREAD_RATIO = 1e-3


# Vectors are lists, matrices lists of rows.
def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def transposed(m):
    return [list(row) for row in zip(*m)]


def product(a, b):
    return [[dot(row, column) for column in zip(*b)] for row in a]


def times(m, v):
    return [dot(row, v) for row in m]


def mean(points):
    return [sum(values) / len(points) for values in zip(*points)]


def rotation_from_quaternion(w, x, y, z):
    n = math.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w / n, x / n, y / n, z / n
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]


def angle_deg(a, b):
    """The angle of the rotation between two orientations."""
    r = product(a, transposed(b))
    sine = math.hypot(r[2][1] - r[1][2], r[0][2] - r[2][0],
                      r[1][0] - r[0][1]) / 2
    return math.degrees(math.atan2(sine, (r[0][0] + r[1][1] + r[2][2] - 1) / 2))


def eigen(matrix):
    """(values, vectors) of a symmetric matrix, by Jacobi's rotations."""
    n = len(matrix)
    a = [list(row) for row in matrix]
    v = [[float(i == j) for j in range(n)] for i in range(n)]
    for _ in range(60):
        off = sum(a[i][j] ** 2 for i in range(n) for j in range(i))
        if off <= 1e-30 * sum(a[i][i] ** 2 for i in range(n)):
            break
        for p in range(n):
            for q in range(p + 1, n):
                if a[p][q] == 0:
                    continue
                angle = math.atan2(2 * a[p][q], a[q][q] - a[p][p]) / 2
                c, s = math.cos(angle), math.sin(angle)
                for m in (a, v):
                    for row in m:
                        row[p], row[q] = (c * row[p] - s * row[q],
                                          s * row[p] + c * row[q])
                a[p], a[q] = ([c * x - s * y for x, y in zip(a[p], a[q])],
                              [s * x + c * y for x, y in zip(a[p], a[q])])
    return [a[i][i] for i in range(n)], transposed(v)


def nearest_rotation(m):
    """The R with the largest trace(R^T m): Horn's quaternion (1987)."""
    (a, b, c), (d, e, f), (g, h, i) = m
    values, vectors = eigen([
        [a + e + i, h - f, c - g, d - b],
        [h - f, a - e - i, b + d, c + g],
        [c - g, b + d, e - a - i, f + h],
        [d - b, c + g, f + h, i - a - e]])
    return rotation_from_quaternion(*vectors[values.index(max(values))])


def on_a_line(offsets):
    scatter = [[sum(o[i] * o[j] for o in offsets) for j in range(3)]
               for i in range(3)]
    values = sorted(max(v, 0) for v in eigen(scatter)[0])
    return math.sqrt(values[1]) < MIN_SPREAD_RATIO * math.sqrt(values[2])


def align(source, target):
    """Poses of `source` in the world of `target`, of names in both.

    Poses are {name: (orientation, centre)}, the orientation cam_from_world.
    None with fewer than three names in common, or cameras at one place.
    """
    names = sorted(set(source) & set(target))
    if len(names) < 3:
        return None
    from_mean = mean([source[name][1] for name in names])
    to_mean = mean([target[name][1] for name in names])
    from_offsets = [minus(source[name][1], from_mean) for name in names]
    to_offsets = [minus(target[name][1], to_mean) for name in names]
    if min(sum(dot(o, o) for o in offsets)
           for offsets in (from_offsets, to_offsets)) <= 1e-20:
        return None
    if on_a_line(from_offsets) or on_a_line(to_offsets):
        turns = [product(transposed(target[name][0]), source[name][0])
                 for name in names]
        covariance = [[sum(t[i][j] for t in turns) for j in range(3)]
                      for i in range(3)]
    else:
        covariance = product(transposed(to_offsets), from_offsets)
    rotation = nearest_rotation(covariance)
    turned = [times(rotation, o) for o in from_offsets]
    scale = (sum(dot(t, o) for t, o in zip(to_offsets, turned)) /
             sum(dot(o, o) for o in from_offsets))
    return {name: (product(source[name][0], transposed(rotation)),
                   [m + scale * x for m, x in zip(to_mean, offset)])
            for name, offset in zip(names, turned)}


def scene_size(poses):
    middle = mean([centre for _, centre in poses.values()])
    return max(math.dist(centre, middle) for _, centre in poses.values())


def pose_errors(poses, truth):
    """The figures of this script; None where they cannot be had."""
    aligned = align(poses, truth)
    if aligned is None:
        return None
    size = scene_size(truth)
    rotations, shares, misplaced = [], [], []
    for name, (orientation, centre) in aligned.items():
        rotations.append(angle_deg(orientation, truth[name][0]))
        shares.append(math.dist(centre, truth[name][1]) / size)
        if rotations[-1] > MISPLACED_DEG or shares[-1] > MISPLACED_SHARE:
            misplaced.append(name)
    return {"compared": len(aligned),
            "rotation_deg_median": statistics.median(rotations),
            "rotation_deg_max": max(rotations),
            "position_share_median": statistics.median(shares),
            "position_share_max": max(shares),
            "misplaced": misplaced}


def camera(orientation, translation):
    """(orientation, centre) of cam_from_world."""
    return orientation, [-x for x in times(transposed(orientation),
                                           translation)]


def read_images_bin(path):
    data = path.read_bytes()
    at = 8
    poses = {}
    for _ in range(struct.unpack_from("<Q", data)[0]):
        pose = struct.unpack_from("<7d", data, at + 4)
        end = data.index(b"\0", at + 64)
        name = data[at + 64:end].decode("utf-8", "replace")
        count = struct.unpack_from("<Q", data, end + 1)[0]
        at = end + 9 + 24 * count
        poses[name] = camera(rotation_from_quaternion(*pose[:4]), pose[4:])
    return poses


def read_images_txt(path):
    lines = [line for line in path.read_text(encoding="utf-8").split("\n")
             if not line.startswith("#")]
    poses = {}
    for line in lines[::2]:  # Each second line holds an image's points.
        words = line.split(maxsplit=9)
        if len(words) == 10:
            pose = [float(word) for word in words[1:8]]
            poses[words[9]] = camera(rotation_from_quaternion(*pose[:4]),
                                     pose[4:])
    return poses


def read_model(folder):
    binary = Path(folder, "images.bin")
    if binary.is_file():
        return read_images_bin(binary)
    return read_images_txt(Path(folder, "images.txt"))


def read_points(folder):
    """(points, mean reprojection error over observations) of points3D.bin."""
    data = Path(folder, "points3D.bin").read_bytes()
    total, observations, at = 0.0, 0, 8
    count = struct.unpack_from("<Q", data)[0]
    for _ in range(count):
        error, track = struct.unpack_from("<dQ", data, at + 35)
        at += 51 + 8 * track
        total += error * track
        observations += track
    return count, total / observations if observations else None


def read_truth(path):
    """{name: (orientation, centre)}; names without folders."""
    if os.path.isdir(path):
        return read_model(path)
    value = json.loads(Path(path).read_text(encoding="utf-8"))
    poses = {}
    if "train" in value:
        for name, matrix in value["train"].items():
            poses[name] = camera([row[:3] for row in matrix[:3]],
                                 [row[3] for row in matrix[:3]])
        return poses
    for frame in value["frames"]:  # camera-to-world; x right, y up, z backward
        matrix = frame["transform_matrix"]
        columns = transposed([row[:3] for row in matrix[:3]])
        orientation = [columns[0], [-x for x in columns[1]],
                       [-x for x in columns[2]]]
        poses[os.path.basename(frame["file_path"])] = (
            orientation, [row[3] for row in matrix[:3]])
    return poses


def main():
    parser = argparse.ArgumentParser(
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model")
    parser.add_argument("truth")
    arguments = parser.parse_args()
    poses = read_model(arguments.model)
    truth = read_truth(arguments.truth)
    errors = pose_errors(poses, truth)
    if errors is None:
        sys.exit(f"{arguments.model}: fewer than three cameras of the truth, "
                 "or all at one place")
    print(f"{len(poses)} cameras, {len(truth)} of the truth, "
          f"{errors['compared']} in both")
    for name in ("rotation_deg", "position_share"):
        print(f"{name}: median {errors[name + '_median']:.5g}, "
              f"largest {errors[name + '_max']:.5g}")
    misplaced = errors["misplaced"]
    print(f"misplaced (above {MISPLACED_DEG:g} degrees or "
          f"{MISPLACED_SHARE:.0%} of the scene's size): {len(misplaced)}"
          + "".join(" " + name for name in misplaced[:10]))


if __name__ == "__main__":
    main()
