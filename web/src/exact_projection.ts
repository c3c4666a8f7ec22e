// SPDX-License-Identifier: BSD-3-Clause
// Spark's projection of Gaussians is changed here so that long and thin images are
// those that the program draws (splat/projection).

import type { SparkRenderer } from "@sparkjsdev/spark";

import { FRUSTUM_MARGIN } from "./blending";

// From the bound in clip space, where the view goes from -1 to 1, back to the place
// that is seen there at the Gaussian's depth.
const LIMIT = (1 + 2 * FRUSTUM_MARGIN).toFixed(6);

// Lines of Spark's shader, and what stands there instead.
const CHANGES: [string, string][] = [
  // Where a Gaussian is far outside of the view, the linear form of the projection
  // makes its image far too long. The program takes the projection's Jacobian at a
  // point near the border of the view instead. Spark has no such bound, and leaves
  // out what is outside. With the bound, walls and floors that reach into the view
  // from outside can be drawn as the program draws them.
  [
    "vec2 J2 = -(J1 * viewCenter.xy) * invZ;",
    `vec2 seen = clamp(clipCenter.xy / clipCenter.w, -${LIMIT}, ${LIMIT});
        vec2 linearAt = -viewCenter.z * (seen + projectionMatrix[2].xy) /
            vec2(projectionMatrix[0][0], projectionMatrix[1][1]);
        vec2 J2 = -(J1 * linearAt) * invZ;`,
  ],
  // Spark takes the width of an image from small differences of large numbers. When
  // an image is thousands of times as long as wide, no digit of them is left. The
  // determinant without blur is the squared length of the cross product of the rows
  // of transpose(J) * R * S. So it is a sum of positive numbers, and loses nothing.
  // This needs scales and rotations. Spark can also have Gaussians that are given by
  // a covariance, but the page has none.
  ["mat3 cov3D;", "mat3 cov3D, deviations;"],
  ["cov3D = RS * transpose(RS);", "deviations = RS;"],
  [
    "mat3 cov2D = transpose(J) * cov3D * J;",
    `mat3 rows = transpose(deviations) * J;
    mat3 cov2D = transpose(rows) * rows;
    vec3 crossed = cross(rows[0], rows[1]);
    float sharpDet = dot(crossed, crossed);`,
  ],
  [
    "float detOrig = a * d - b * b;",
    "float detOrig = sharpDet + preBlurAmount * (a + d - preBlurAmount);",
  ],
  [
    "float det = a * d - b * b;",
    `float blur = preBlurAmount + fullBlurAmount;
    float det = sharpDet + blur * (a + d - blur);`,
  ],
  [
    "float eigenDelta = sqrt(max(0.0, eigenAvg * eigenAvg - det));",
    "float eigenDelta = length(vec2(0.5 * (a - d), b));",
  ],
  ["float eigen2 = eigenAvg - eigenDelta;", "float eigen2 = det / eigen1;"],
  // The direction, too, with a sum in place of a difference.
  [
    "vec2 eigenVec1 = (abs(b) > 0.001) ? normalize(vec2(b, eigen1 - a))",
    `vec2 eigenVec1 = (abs(b) > 0.001)
        ? normalize(a >= d ? vec2(eigen1 - d, b) : vec2(b, eigen1 - a))`,
  ],
];

/** Must come before the first frame. Throws if Spark's shader has changed. */
export function projectExactly(spark: SparkRenderer): void {
  const { material } = spark;
  let shader = material.vertexShader;
  for (const [known, exact] of CHANGES) {
    const around = shader.split(known);
    if (around.length !== 2) {
      throw new Error("Spark's shader is not the one that is known");
    }
    shader = around.join(exact);
  }
  material.vertexShader = shader;
}
