// SPDX-License-Identifier: BSD-3-Clause
// Lines over the scene: the photos' cameras and the boxes of the objects.

import * as THREE from "three";

import { photoPose } from "./cameras";
import type { SceneDescription, SceneObject } from "./scene_data";

function lines(points: THREE.Vector3[], colors: THREE.Color[], opacity: number) {
  const geometry = new THREE.BufferGeometry().setFromPoints(points);
  geometry.setAttribute(
    "color",
    new THREE.Float32BufferAttribute(
      colors.flatMap((color) => color.toArray()),
      3,
    ),
  );
  const material = new THREE.LineBasicMaterial({
    vertexColors: true,
    transparent: true,
    opacity,
    // Gaussians leave no depth, so lines are drawn over them.
    depthTest: false,
    depthWrite: false,
  });
  const object = new THREE.LineSegments(geometry, material);
  object.renderOrder = 10;
  object.frustumCulled = false;
  return object;
}

/** A pyramid per camera; holdout photos in another colour. */
export function cameraLines(scene: SceneDescription): THREE.LineSegments {
  const points: THREE.Vector3[] = [];
  const colors: THREE.Color[] = [];
  const size = 0.06 * scene.radius;
  for (const photo of scene.photos) {
    const pose = photoPose(photo);
    const corner = (x: number, y: number) =>
      new THREE.Vector3(
        ((x - photo.cx) / photo.fx) * size,
        (-(y - photo.cy) / photo.fy) * size,
        -size,
      ).applyMatrix4(pose);
    const eye = new THREE.Vector3().setFromMatrixPosition(pose);
    const ring = [
      corner(0, 0),
      corner(photo.width, 0),
      corner(photo.width, photo.height),
      corner(0, photo.height),
    ];
    ring.forEach((point, i) => points.push(eye, point, point, ring[(i + 1) % 4]));
    const color = new THREE.Color(photo.holdout ? 0xffa94d : 0x74c0fc);
    while (colors.length < points.length) colors.push(color);
  }
  return lines(points, colors, 0.8);
}

const EDGES = [
  [0, 1],
  [2, 3],
  [4, 5],
  [6, 7],
  [0, 2],
  [1, 3],
  [4, 6],
  [5, 7],
  [0, 4],
  [1, 5],
  [2, 6],
  [3, 7],
];

export function boxLines(objects: SceneObject[]): THREE.LineSegments {
  const points: THREE.Vector3[] = [];
  const colors: THREE.Color[] = [];
  for (const { obb, color } of objects) {
    const corners = Array.from({ length: 8 }, (_, k) => {
      const half = [0, 1, 2].map((i) => ((k >> i) & 1 ? 0.5 : -0.5) * obb.size[i]);
      // The columns of the rotation are the axes of the box.
      return new THREE.Vector3(
        ...([0, 1, 2].map(
          (row) =>
            obb.center[row] +
            obb.rotation[row][0] * half[0] +
            obb.rotation[row][1] * half[1] +
            obb.rotation[row][2] * half[2],
        ) as [number, number, number]),
      );
    });
    const shade = new THREE.Color().setRGB(
      color[0] / 255,
      color[1] / 255,
      color[2] / 255,
      THREE.SRGBColorSpace,
    );
    for (const [a, b] of EDGES) {
      points.push(corners[a], corners[b]);
      colors.push(shade, shade);
    }
  }
  return lines(points, colors, 0.95);
}
