// SPDX-License-Identifier: BSD-3-Clause
// The Gaussians on the graphics card, and what the page knows of each.

import {
  dyno,
  readRgbaArray,
  RgbaArray,
  SplatFileType,
  SplatMesh,
} from "@sparkjsdev/spark";
import * as THREE from "three";

import type { Gaussians } from "./blending";
import type { SceneDescription, ScenePart, SceneSource } from "./scene_data";
import type { Selection } from "./selection";

/** Mixes in what Selection.paint wrote for each Gaussian. */
function paintModifier(state: RgbaArray) {
  return dyno.dynoBlock(
    { gsplat: dyno.Gsplat },
    { gsplat: dyno.Gsplat },
    ({ gsplat }) => {
      if (!gsplat) throw new Error("the modifier has no input");
      const { index } = dyno.splitGsplat(gsplat).outputs;
      const painted = new dyno.Dyno({
        inTypes: { gsplat: dyno.Gsplat, paint: "vec4" },
        outTypes: { gsplat: dyno.Gsplat },
        inputs: { gsplat, paint: readRgbaArray(state.dyno, index) },
        statements: ({ inputs, outputs }) => [
          `${outputs.gsplat} = ${inputs.gsplat};`,
          `if (${inputs.paint}.a > 0.998) ${outputs.gsplat}.rgba.a = 0.0;`,
          `${outputs.gsplat}.rgba.rgb = mix(${inputs.gsplat}.rgba.rgb,` +
            ` ${inputs.paint}.rgb, min(1.0, ${inputs.paint}.a * 255.0 / 254.0));`,
        ],
      });
      return { gsplat: painted.outputs.gsplat };
    },
  );
}

interface Part {
  mesh: SplatMesh;
  labels: Uint16Array;
  state: RgbaArray;
  first: number;
}

export class SplatCloud {
  readonly gaussians: Gaussians;
  /** Per Gaussian the object's id and its part. */
  readonly labels: Uint16Array;
  private readonly colors: Float32Array;
  private readonly parts: Part[] = [];
  private fewer = false;

  constructor(
    scene: SceneDescription,
    private readonly root: THREE.Object3D,
    private readonly selection: Selection,
  ) {
    const count = scene.num_gaussians;
    this.gaussians = {
      count: 0,
      means: new Float32Array(3 * count),
      scales: new Float32Array(3 * count),
      rotations: new Float32Array(4 * count),
      opacities: new Float32Array(count),
      antialiased: scene.antialiased,
    };
    this.colors = new Float32Array(3 * count);
    this.labels = new Uint16Array(2 * count);
    selection.onChange(() => this.repaint());
  }

  /** Adds one part after the other; `onPart` after each. */
  async load(source: SceneSource, onPart: () => void): Promise<void> {
    for (let i = 0; i < source.description.parts.length; ++i) {
      await this.add(await source.part(i));
      onPart();
    }
  }

  private async add(part: ScenePart): Promise<void> {
    const count = part.labels.length / 2;
    const state = new RgbaArray();
    state.ensureCapacity(count);
    state.count = count;
    const mesh = new SplatMesh({
      fileBytes: part.splats,
      fileType: SplatFileType.SPZ,
      // Positions in half floats would be off by a hundredth of the scene.
      extSplats: true,
      raycastable: false,
      objectModifier: paintModifier(state),
    });
    await mesh.initialized;
    const first = this.gaussians.count;
    let seen = 0;
    mesh.forEachSplat((i, center, scales, quaternion, opacity, color) => {
      if (i >= count) return;
      ++seen;
      center.toArray(this.gaussians.means, 3 * (first + i));
      scales.toArray(this.gaussians.scales, 3 * (first + i));
      quaternion.toArray(this.gaussians.rotations, 4 * (first + i));
      this.gaussians.opacities[first + i] = opacity;
      color.toArray(this.colors, 3 * (first + i));
    });
    if (seen !== count) {
      throw new Error(`the scene has ${seen} Gaussians and ${count} labels`);
    }
    this.labels.set(part.labels, 2 * first);
    this.gaussians.count += count;
    const added = { mesh, labels: part.labels, state, first };
    // Not before the wait: what is chosen or shown may have changed meanwhile.
    this.paint(added);
    mesh.visible = !this.fewer || this.parts.length === 0;
    this.parts.push(added);
    this.root.add(mesh);
  }

  /** Shows only the first, most important part of several. */
  showFewer(fewer: boolean): void {
    this.fewer = fewer;
    this.parts.forEach((part, i) => (part.mesh.visible = !fewer || i === 0));
  }

  objectOf(index: number): number {
    return this.labels[2 * index];
  }

  partOf(index: number): number {
    return this.labels[2 * index + 1];
  }

  isVisible(index: number): boolean {
    return this.selection.isVisible(this.objectOf(index), this.partOf(index));
  }

  isChosen(index: number): boolean {
    return this.selection.isChosen(this.objectOf(index), this.partOf(index));
  }

  /** The colour without what depends on the direction, 0 to 1. */
  colorOf(index: number): [number, number, number] {
    return [
      this.colors[3 * index],
      this.colors[3 * index + 1],
      this.colors[3 * index + 2],
    ];
  }

  /** Writes anew what Selection.paint tells of all Gaussians. */
  repaint(): void {
    for (const part of this.parts) this.paint(part);
  }

  private paint({ mesh, labels, state }: Part): void {
    this.selection.paint(labels, state.ensureCapacity(state.count));
    state.needsUpdate = true;
    mesh.updateVersion();
  }
}
