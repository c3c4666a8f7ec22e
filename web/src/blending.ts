// SPDX-License-Identifier: BSD-3-Clause
// Blends Gaussians on the processor, as the program's renderer does (EWA
// splatting, Zwicker et al. 2001): exact answers to "which object is at this
// pixel" and "which pixels show it", whatever the graphics card draws.

/** Gaussians in the frame of the scene. */
export interface Gaussians {
  count: number;
  means: Float32Array; // count x 3
  scales: Float32Array; // count x 3, standard deviations
  rotations: Float32Array; // count x 4, x y z w
  opacities: Float32Array; // count
  /** Whether small Gaussians are made fainter (Mip-Splatting). */
  antialiased: boolean;
}

/** Pixels; `rotation` is camera from scene, row by row, y down, z forward. */
export interface PinholePose {
  width: number;
  height: number;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
  rotation: ArrayLike<number>; // 9
  translation: ArrayLike<number>; // 3
}

// Facts of the method, as in splat/projection.
export const NEAR_PLANE = 0.2;
const DILATION = 0.3; // Pixels squared.
const MIN_ALPHA = 1 / 255;
const MAX_ALPHA = 0.99;
const MIN_TRANSMITTANCE = 1e-4;
const MIN_FILTER = 2.5e-5; // As in LogOpacityFilter.
// A pixel where the labels' weights sum to less has no object, as in
// semantics/queries/click_query.
const MIN_WEIGHT = 0.5;
// The projection counts as linear up to so much of the image's size outside.
export const FRUSTUM_MARGIN = 0.15;

/** A Gaussian on the image plane: centre, inverse covariance, reach. */
interface Splat {
  index: number;
  depth: number;
  x: number;
  y: number;
  a: number;
  b: number;
  c: number;
  radius: number;
  opacity: number;
}

function clamp(value: number, low: number, high: number): number {
  return Math.min(high, Math.max(low, value));
}

function project(g: Gaussians, i: number, camera: PinholePose): Splat | null {
  const r = camera.rotation;
  const t = camera.translation;
  const mx = g.means[3 * i];
  const my = g.means[3 * i + 1];
  const mz = g.means[3 * i + 2];
  const z = r[6] * mx + r[7] * my + r[8] * mz + t[2];
  if (!(z > NEAR_PLANE) || g.opacities[i] < MIN_ALPHA) return null;
  const x = r[0] * mx + r[1] * my + r[2] * mz + t[0];
  const y = r[3] * mx + r[4] * my + r[5] * mz + t[1];
  const px = (camera.fx * x) / z + camera.cx;
  const py = (camera.fy * y) / z + camera.cy;

  // Three standard deviations of a ball of its largest size: far from the
  // image for most Gaussians outside of it.
  const size = Math.max(g.scales[3 * i], g.scales[3 * i + 1], g.scales[3 * i + 2]);
  const rough = (4 * Math.max(camera.fx, camera.fy) * size) / z + 4;
  if (
    px < -2 * rough ||
    py < -2 * rough ||
    px > camera.width + 2 * rough ||
    py > camera.height + 2 * rough
  ) {
    return null;
  }

  // Rotation of the Gaussian times its scales, in the camera's frame.
  const qx = g.rotations[4 * i];
  const qy = g.rotations[4 * i + 1];
  const qz = g.rotations[4 * i + 2];
  const qw = g.rotations[4 * i + 3];
  const axes = [
    1 - 2 * (qy * qy + qz * qz),
    2 * (qx * qy - qw * qz),
    2 * (qx * qz + qw * qy),
    2 * (qx * qy + qw * qz),
    1 - 2 * (qx * qx + qz * qz),
    2 * (qy * qz - qw * qx),
    2 * (qx * qz - qw * qy),
    2 * (qy * qz + qw * qx),
    1 - 2 * (qx * qx + qy * qy),
  ];
  // The Jacobian of the projection at a point that is not far outside.
  const { width, height } = camera;
  const u = clamp(
    x / z,
    (-camera.cx - FRUSTUM_MARGIN * width) / camera.fx,
    (width - camera.cx + FRUSTUM_MARGIN * width) / camera.fx,
  );
  const v = clamp(
    y / z,
    (-camera.cy - FRUSTUM_MARGIN * height) / camera.fy,
    (height - camera.cy + FRUSTUM_MARGIN * height) / camera.fy,
  );
  const jx = camera.fx / z;
  const jy = camera.fy / z;
  let xx = 0;
  let xy = 0;
  let yy = 0;
  for (let k = 0; k < 3; ++k) {
    const s = g.scales[3 * i + k];
    const ax = axes[k] * s;
    const ay = axes[3 + k] * s;
    const az = axes[6 + k] * s;
    const cx = r[0] * ax + r[1] * ay + r[2] * az;
    const cy = r[3] * ax + r[4] * ay + r[5] * az;
    const cz = r[6] * ax + r[7] * ay + r[8] * az;
    const across = jx * (cx - u * cz);
    const down = jy * (cy - v * cz);
    xx += across * across;
    xy += across * down;
    yy += down * down;
  }
  const sharp = xx * yy - xy * xy;
  xx += DILATION;
  yy += DILATION;
  const determinant = xx * yy - xy * xy;
  if (!(determinant > 0)) return null;
  const middle = 0.5 * (xx + yy);
  const largest = middle + Math.sqrt(Math.max(0, middle * middle - determinant));
  const filter = g.antialiased
    ? Math.sqrt(Math.max(sharp / determinant, MIN_FILTER))
    : 1;
  const opacity = g.opacities[i] * filter;
  const radius = Math.sqrt(2 * Math.log(opacity / MIN_ALPHA) * largest);
  if (
    !(radius > 0) ||
    px + radius < 0 ||
    py + radius < 0 ||
    px - radius > camera.width ||
    py - radius > camera.height
  ) {
    return null;
  }
  return {
    index: i,
    depth: z,
    x: px,
    y: py,
    a: yy / determinant,
    b: -xy / determinant,
    c: xx / determinant,
    radius,
    opacity,
  };
}

function alphaAt(splat: Splat, x: number, y: number): number {
  const dx = x - splat.x;
  const dy = y - splat.y;
  const power = 0.5 * (splat.a * dx * dx + splat.c * dy * dy) + splat.b * dx * dy;
  if (power < 0) return 0;
  const alpha = Math.min(MAX_ALPHA, splat.opacity * Math.exp(-power));
  return alpha < MIN_ALPHA ? 0 : alpha;
}

const byDepth = (a: Splat, b: Splat) => a.depth - b.depth || a.index - b.index;

/** What a pixel shows. */
export interface Pick {
  /** The label of the largest weight. */
  label: number;
  weight: number;
  /** The Gaussian of that label with the largest weight. */
  gaussian: number;
}

/**
 * The label of the largest summed blending weight at a point of the image, as
 * `freegs_pipeline query --click` answers. Gaussians of a negative label are
 * left out, and label 0 is no answer. Nothing where the labels above 0 make up
 * less than half of what the point shows.
 */
export function pickLabel(
  gaussians: Gaussians,
  label: (index: number) => number,
  camera: PinholePose,
  x: number,
  y: number,
): Pick | null {
  const hit: Splat[] = [];
  for (let i = 0; i < gaussians.count; ++i) {
    if (label(i) < 0) continue;
    const splat = project(gaussians, i, camera);
    if (splat && alphaAt(splat, x, y) > 0) hit.push(splat);
  }
  hit.sort(byDepth);
  const weights = new Map<number, { sum: number; best: number; index: number }>();
  let transmittance = 1;
  for (const splat of hit) {
    const alpha = alphaAt(splat, x, y);
    const weight = alpha * transmittance;
    const key = label(splat.index);
    const entry = weights.get(key) ?? { sum: 0, best: 0, index: splat.index };
    entry.sum += weight;
    if (weight > entry.best) {
      entry.best = weight;
      entry.index = splat.index;
    }
    weights.set(key, entry);
    transmittance *= 1 - alpha;
    if (transmittance < MIN_TRANSMITTANCE) break;
  }
  let best: Pick | null = null;
  let total = 0;
  for (const [key, entry] of weights) {
    if (key <= 0) continue;
    total += entry.sum;
    if (!best || entry.sum > best.weight) {
      best = { label: key, weight: entry.sum, gaussian: entry.index };
    }
  }
  return total < MIN_WEIGHT ? null : best;
}

/**
 * 1 where Gaussians that are `chosen` cover at least half of a pixel, as in the
 * masks of the program, else 0; row by row. Gaussians that are not `visible` are
 * left out.
 */
export function renderMask(
  gaussians: Gaussians,
  visible: (index: number) => boolean,
  chosen: (index: number) => boolean,
  camera: PinholePose,
): Uint8Array {
  const { width, height } = camera;
  const splats: Splat[] = [];
  for (let i = 0; i < gaussians.count; ++i) {
    const splat = visible(i) ? project(gaussians, i, camera) : null;
    if (splat) splats.push(splat);
  }
  splats.sort(byDepth);
  const transmittance = new Float32Array(width * height).fill(1);
  const weight = new Float32Array(width * height);
  for (const splat of splats) {
    const mine = chosen(splat.index);
    const x0 = Math.max(0, Math.floor(splat.x - splat.radius));
    const x1 = Math.min(width - 1, Math.ceil(splat.x + splat.radius));
    const y0 = Math.max(0, Math.floor(splat.y - splat.radius));
    const y1 = Math.min(height - 1, Math.ceil(splat.y + splat.radius));
    for (let py = y0; py <= y1; ++py) {
      for (let px = x0; px <= x1; ++px) {
        const at = py * width + px;
        const left = transmittance[at];
        if (left < MIN_TRANSMITTANCE) continue;
        const alpha = alphaAt(splat, px + 0.5, py + 0.5);
        if (mine) weight[at] += alpha * left;
        transmittance[at] = left * (1 - alpha);
      }
    }
  }
  const mask = new Uint8Array(width * height);
  for (let i = 0; i < mask.length; ++i) {
    mask[i] = weight[i] >= MIN_WEIGHT ? 1 : 0;
  }
  return mask;
}
