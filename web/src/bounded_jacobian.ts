// SPDX-License-Identifier: BSD-3-Clause
// Where a Gaussian is far outside of the view, the linear form of the projection
// makes its image far too long. The program takes the projection's Jacobian at a
// point near the border of the view instead. Spark has no such bound, and leaves
// out what is outside. With the bound, walls and floors that reach into the view
// from outside can be drawn as the program draws them.

import type { SparkRenderer } from "@sparkjsdev/spark";

import { FRUSTUM_MARGIN } from "./blending";

/** Must come before the first frame. Throws if Spark's shader has changed. */
export function boundJacobian(spark: SparkRenderer): void {
  const { material } = spark;
  const shader = material.vertexShader;
  // From the bound in clip space, where the view goes from -1 to 1, back to the
  // place that is seen there at the Gaussian's depth.
  const limit = (1 + 2 * FRUSTUM_MARGIN).toFixed(6);
  const bounded = shader.replace(
    "vec2 J2 = -(J1 * viewCenter.xy) * invZ;",
    `vec2 seen = clamp(clipCenter.xy / clipCenter.w, -${limit}, ${limit});
        vec2 linearAt = -viewCenter.z * (seen + projectionMatrix[2].xy) /
            vec2(projectionMatrix[0][0], projectionMatrix[1][1]);
        vec2 J2 = -(J1 * linearAt) * invZ;`,
  );
  if (bounded === shader) {
    throw new Error("Spark's shader is not the one that is known");
  }
  material.vertexShader = bounded;
}
