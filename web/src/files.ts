// SPDX-License-Identifier: BSD-3-Clause
// Files that the page saves: masks and objects.

import type { SceneDescription } from "./scene_data";
import type { SplatCloud } from "./splat_cloud";

const SH_C0 = 0.28209479177387814;
// A scene so many units from the world's origin is far away, as
// ModelFrame::IsFarAway says (splat/scene/model_frame.h).
const FAR_AWAY = 5000;

/** Saves what is at an address. A name that a server gives would win. */
export function saveFrom(address: string, name: string): void {
  const link = document.createElement("a");
  link.href = address;
  link.download = name.replace(/[\\/:*?"<>|\u0000-\u001f]+/g, "_");
  link.click();
}

export function saveBlob(blob: Blob, name: string): void {
  const address = URL.createObjectURL(blob);
  saveFrom(address, name);
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}

/** A grey PNG of 0 and 255. */
export async function maskPng(
  mask: Uint8Array,
  width: number,
  height: number,
): Promise<Blob> {
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  const context = canvas.getContext("2d");
  if (!context) throw new Error("the browser cannot draw pictures");
  const image = context.createImageData(width, height);
  for (let i = 0; i < mask.length; ++i) {
    image.data.fill(mask[i] ? 255 : 0, 4 * i, 4 * i + 3);
    image.data[4 * i + 3] = 255;
  }
  context.putImageData(image, 0, 0);
  return new Promise((resolve, reject) =>
    canvas.toBlob(
      (blob) => (blob ? resolve(blob) : reject(new Error("no picture was made"))),
      "image/png",
    ),
  );
}

/**
 * The chosen Gaussians in the common layout of 3DGS, in the world frame. The
 * positions of a scene far away count from the point in the line "comment
 * offset", because float32 would round them too much. Colours are those without
 * what depends on the direction, and as exact as the page's scene file;
 * `freegs_pipeline export --only` writes all there is.
 */
export function chosenPly(scene: SceneDescription, cloud: SplatCloud): Blob {
  const { gaussians } = cloud;
  const chosen: number[] = [];
  for (let i = 0; i < gaussians.count; ++i) if (cloud.isChosen(i)) chosen.push(i);
  const names = [
    ...["x", "y", "z", "nx", "ny", "nz"],
    ...["f_dc_0", "f_dc_1", "f_dc_2", "opacity"],
    ...["scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"],
  ];
  const far = Math.hypot(...scene.origin) > FAR_AWAY * scene.unit;
  const header =
    "ply\nformat binary_little_endian 1.0\n" +
    (far ? `comment offset ${scene.origin.join(" ")}\n` : "") +
    (scene.antialiased ? "comment SplatRenderMode: mip\n" : "") +
    `element vertex ${chosen.length}\n` +
    names.map((name) => `property float ${name}\n`).join("") +
    "end_header\n";
  const bytes = new DataView(new ArrayBuffer(4 * names.length * chosen.length));
  let at = 0;
  const put = (value: number) => {
    bytes.setFloat32(at, value, true);
    at += 4;
  };
  for (const i of chosen) {
    for (let k = 0; k < 3; ++k) {
      put(gaussians.means[3 * i + k] * scene.unit + (far ? 0 : scene.origin[k]));
    }
    for (let k = 0; k < 3; ++k) put(0);
    for (const channel of cloud.colorOf(i)) put((channel - 0.5) / SH_C0);
    const opacity = Math.min(1 - 1e-6, Math.max(1e-6, gaussians.opacities[i]));
    put(Math.log(opacity / (1 - opacity)));
    for (let k = 0; k < 3; ++k) {
      put(Math.log(Math.max(1e-12, gaussians.scales[3 * i + k] * scene.unit)));
    }
    put(gaussians.rotations[4 * i + 3]);
    for (let k = 0; k < 3; ++k) put(gaussians.rotations[4 * i + k]);
  }
  return new Blob([header, bytes.buffer], { type: "application/octet-stream" });
}
