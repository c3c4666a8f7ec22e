// SPDX-License-Identifier: BSD-3-Clause
// Between the program's cameras (x right, y down, z forward, pixels) and those
// of three.js (y up, z backward, clip space).

import * as THREE from "three";

import type { PinholePose } from "./blending";
import type { Photo, SceneDescription } from "./scene_data";

/** Rotates the scene so that its upward direction becomes three.js's. */
export function uprightRotation(scene: SceneDescription): THREE.Quaternion {
  return new THREE.Quaternion().setFromUnitVectors(
    new THREE.Vector3(...scene.up).normalize(),
    new THREE.Vector3(0, 1, 0),
  );
}

const flip = new THREE.Matrix4().makeScale(1, -1, -1);

/** The pose of a photo's camera in the frame of the scene, as three.js has it. */
export function photoPose(photo: Photo): THREE.Matrix4 {
  const [w, x, y, z] = photo.rotation;
  return new THREE.Matrix4()
    .makeRotationFromQuaternion(new THREE.Quaternion(x, y, z, w))
    .setPosition(...photo.translation)
    .invert()
    .multiply(flip);
}

/** The largest rectangle of the photo's shape inside the view, in pixels. */
export function photoRectangle(photo: Photo, width: number, height: number) {
  const scale = Math.min(width / photo.width, height / photo.height);
  return {
    scale,
    x: (width - scale * photo.width) / 2,
    y: (height - scale * photo.height) / 2,
    width: scale * photo.width,
    height: scale * photo.height,
  };
}

/**
 * Lets the camera see what the photo shows, inside photoRectangle; around it,
 * what the photographer would have seen with a larger picture.
 */
export function projectLikePhoto(
  camera: THREE.PerspectiveCamera,
  photo: Photo,
  width: number,
  height: number,
): void {
  const { scale, x, y } = photoRectangle(photo, width, height);
  const fy = scale * photo.fy;
  camera.fov = (360 / Math.PI) * Math.atan(height / (2 * fy));
  // The principal point is moved by looking at a part of a larger picture.
  const cx = x + scale * photo.cx;
  const cy = y + scale * photo.cy;
  camera.setViewOffset(width, height, width / 2 - cx, height / 2 - cy, width, height);
  // The focal lengths differ by parts of a thousand at most.
  camera.aspect = ((width / height) * photo.fy) / photo.fx;
  camera.updateProjectionMatrix();
}

/** As wide as before, whatever that was. */
export function projectFreely(
  camera: THREE.PerspectiveCamera,
  width: number,
  height: number,
): void {
  camera.clearViewOffset();
  camera.aspect = width / height;
  camera.updateProjectionMatrix();
}

/** What a camera of three.js sees of the scene, as a pinhole camera. */
export function pinholeOf(
  camera: THREE.PerspectiveCamera,
  root: THREE.Object3D,
  width: number,
  height: number,
): PinholePose {
  camera.updateMatrixWorld();
  root.updateMatrixWorld();
  const pose = camera.matrixWorld
    .clone()
    .invert()
    .multiply(root.matrixWorld)
    .premultiply(flip).elements;
  const p = camera.projectionMatrix.elements;
  return {
    width,
    height,
    fx: (p[0] * width) / 2,
    fy: (p[5] * height) / 2,
    cx: ((1 - p[8]) * width) / 2,
    cy: ((1 + p[9]) * height) / 2,
    // Row by row; three.js keeps columns.
    rotation: [
      pose[0],
      pose[4],
      pose[8],
      pose[1],
      pose[5],
      pose[9],
      pose[2],
      pose[6],
      pose[10],
    ],
    translation: [pose[12], pose[13], pose[14]],
  };
}
