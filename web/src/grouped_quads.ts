// SPDX-License-Identifier: BSD-3-Clause
// Spark draws one instance of a square per Gaussian. Renderers without a graphics
// card draw instances one by one, and each costs them as much as hundreds of
// vertices; many graphics cards fill their lanes with one instance at a time. So
// an instance gets many squares here.

import type { SparkRenderer } from "@sparkjsdev/spark";
import * as THREE from "three";

const SQUARES = 256;

class GroupedSquares extends THREE.InstancedBufferGeometry {
  readonly splatCount = { value: 0 };

  constructor() {
    super();
    const positions = new Float32Array(SQUARES * 12);
    const indices = new Uint16Array(SQUARES * 6);
    for (let i = 0; i < SQUARES; ++i) {
      // Corners as Spark has them; z is the number of the square.
      positions.set([-1, -1, i, 1, -1, i, 1, 1, i, -1, 1, i], 12 * i);
      indices.set(
        [0, 1, 2, 0, 2, 3].map((corner) => 4 * i + corner),
        6 * i,
      );
    }
    this.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    this.setIndex(new THREE.BufferAttribute(indices, 1));
    // Spark sets the number of Gaussians, three.js asks for that of instances.
    Object.defineProperty(this, "instanceCount", {
      get: () => Math.ceil(this.splatCount.value / SQUARES),
      set: (count: number) => (this.splatCount.value = Number.isFinite(count) ? count : 0),
    });
  }
}

/** Must come before the first frame. Throws if Spark's shader has changed. */
export function groupSquares(spark: SparkRenderer): void {
  const squares = new GroupedSquares();
  const { material } = spark;
  const shader = material.vertexShader;
  const grouped = shader
    .replaceAll("gl_InstanceID", "splatNumber")
    .replace(
      "void main() {",
      `uniform int splatCount;
      void main() {
        int splatNumber = gl_InstanceID * ${SQUARES} + int(position.z);
        if (splatNumber >= splatCount) {
          gl_Position = vec4(0.0, 0.0, 2.0, 1.0);
          return;
        }`,
    );
  if (grouped === shader || !shader.includes("gl_InstanceID")) {
    throw new Error("Spark's shader is not the one that is known");
  }
  material.vertexShader = grouped;
  material.uniforms.splatCount = squares.splatCount;
  spark.geometry.dispose();
  spark.geometry = squares;
}
