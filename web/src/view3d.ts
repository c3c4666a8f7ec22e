// SPDX-License-Identifier: BSD-3-Clause
// The canvas: draws the Gaussians and the lines when something has changed, and
// answers what a pixel shows.

import { SparkRenderer } from "@sparkjsdev/spark";
import * as THREE from "three";

import { NEAR_PLANE, pickLabel, renderMask, type PinholePose } from "./blending";
import { projectExactly } from "./exact_projection";
import {
  photoPose,
  photoRectangle,
  pinholeOf,
  projectFreely,
  projectLikePhoto,
  uprightRotation,
} from "./cameras";
import { groupSquares } from "./grouped_quads";
import { Navigation } from "./navigation";
import { boxLines, cameraLines } from "./overlays";
import type { Photo, SceneDescription, SceneObject } from "./scene_data";
import type { Selection } from "./selection";
import { SplatCloud } from "./splat_cloud";

// While the camera moves, a frame should take no longer than this; at rest it is
// drawn once more with all there is.
const SLOW_MILLISECONDS = 120;
const FAST_MILLISECONDS = 30;
const FAST_FRAMES = 30;
const REST_MILLISECONDS = 300;

// What is left out step by step. From the second step on, colours and the order
// of drawing are those of a camera at most so long ago.
const STEPS: { resolution: number; fewer: boolean }[] = [
  { resolution: 1, fewer: false },
  { resolution: 0.6, fewer: false },
  { resolution: 0.4, fewer: false },
  { resolution: 0.4, fewer: true },
];
const UPDATE_MILLISECONDS = 1000;

// In units of the scene. The program leaves no Gaussian out for being far away;
// stages/viewer brings the farthest to 32767 along each axis.
const FAR_PLANE = 1e5;

// Larger than any size in pixels. Shaders need not know infinity.
const UNBOUNDED = 1e9;

export interface FrameStatistics {
  /** Milliseconds from the start of the page to the first full frame. */
  first: number | null;
  /** When frames were drawn, in milliseconds. The newest are last. */
  times: number[];
}

export class View3d {
  readonly cloud: SplatCloud;
  readonly navigation: Navigation;
  readonly statistics: FrameStatistics = { first: null, times: [] };
  photo: Photo | null = null;

  private readonly renderer: THREE.WebGLRenderer;
  private readonly camera: THREE.PerspectiveCamera;
  private readonly spark: SparkRenderer;
  private readonly world = new THREE.Scene();
  private readonly root = new THREE.Group();
  private readonly cameras: THREE.LineSegments;
  private readonly boxes: THREE.LineSegments;
  private lit: THREE.LineSegments | null = null;
  private dirty = true;
  private movedAt = -Infinity;
  private lastFrame = 0;
  private lastUpdate = 0;
  private resolution = 1;
  /** What moving needs on this machine, and what was drawn last. */
  private step = 0;
  private drawnStep = 0;
  private fastFrames = 0;
  private drewLastTick = false;
  private photoListener: () => void = () => {};

  /**
   * Throws where there is no WebGL 2. The first view depends on the size of
   * `holder`, so home() has to be called once that is part of the page.
   */
  constructor(
    private readonly holder: HTMLElement,
    private readonly scene: SceneDescription,
    private readonly selection: Selection,
  ) {
    this.renderer = new THREE.WebGLRenderer({
      antialias: false,
      preserveDrawingBuffer: true, // For pictures of the canvas.
    });
    const canvas = this.renderer.domElement;
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "application");
    canvas.setAttribute(
      "aria-label",
      "3D scene. Arrow keys turn, plus and minus come nearer and go away, " +
        "Enter chooses the object in the middle.",
    );
    holder.append(canvas);
    canvas.addEventListener("webglcontextrestored", () => this.restore());
    const [r, g, b] = scene.background;
    this.world.background = new THREE.Color().setRGB(r, g, b, THREE.SRGBColorSpace);
    this.root.quaternion.copy(uprightRotation(scene));
    this.world.add(this.root);
    this.spark = new SparkRenderer({
      renderer: this.renderer,
      onDirty: () => this.redraw(),
      accumExtSplats: true,
      sortRadial: false,
      enableLod: false,
      // By default Spark makes large Gaussians smaller, and leaves out those whose
      // centre is outside of the view.
      maxPixelRadius: UNBOUNDED,
      clipXY: UNBOUNDED,
      preBlurAmount: scene.antialiased ? 0 : 0.3,
      blurAmount: scene.antialiased ? 0.3 : 0,
    });
    projectExactly(this.spark);
    groupSquares(this.spark);
    this.world.add(this.spark);
    this.cloud = new SplatCloud(scene, this.root, selection);
    this.cameras = cameraLines(scene);
    this.boxes = boxLines(scene.objects.filter((object) => !object.background));
    this.cameras.visible = this.boxes.visible = false;
    this.root.add(this.cameras, this.boxes);
    selection.onChange(() => this.showChoice());

    this.camera = new THREE.PerspectiveCamera(50, 1, NEAR_PLANE, FAR_PLANE);
    this.navigation = new Navigation(this.camera, canvas, scene.radius, () =>
      this.moved(),
    );
    new ResizeObserver(() => this.resize()).observe(holder);
    this.resize();
    this.renderer.setAnimationLoop((now) => this.tick(now));
  }

  get canvas(): HTMLCanvasElement {
    return this.renderer.domElement;
  }

  /** Told when the camera came to a photo, or left it. */
  onPhoto(listener: () => void): void {
    this.photoListener = listener;
  }

  redraw(): void {
    this.dirty = true;
  }

  showCameras(visible: boolean): void {
    this.cameras.visible = visible;
    this.redraw();
  }

  showBoxes(visible: boolean): void {
    this.boxes.visible = visible;
    this.redraw();
  }

  /** The first view: that of the photo in the middle of the list. */
  home(): void {
    const photos = this.scene.photos;
    if (photos.length > 0) {
      const photo = photos[photos.length >> 1];
      this.stand(photo);
      // Upright, whatever way the photographer held the camera.
      this.navigation.lookAt(this.navigation.target.clone());
    } else {
      const focus = this.toWorld(this.scene.focus);
      this.camera.position
        .copy(focus)
        .add(new THREE.Vector3(0, 0.5, 1).multiplyScalar(2 * this.scene.radius));
      this.navigation.lookAt(focus);
    }
  }

  goTo(photo: Photo): void {
    this.stand(photo);
    this.photoListener();
  }

  private stand(photo: Photo): void {
    this.root.updateMatrixWorld();
    const pose = photoPose(photo).premultiply(this.root.matrixWorld);
    pose.decompose(this.camera.position, this.camera.quaternion, new THREE.Vector3());
    const focus = this.toWorld(this.scene.focus);
    const ahead = focus
      .sub(this.camera.position)
      .dot(this.camera.getWorldDirection(new THREE.Vector3()));
    this.navigation.aim(Math.max(ahead, 0.1 * this.scene.radius));
    this.photo = photo;
    this.resize();
  }

  /** Frames an object from the direction of now. */
  approach(object: SceneObject): void {
    const center = this.toWorld(object.obb.center);
    const size = Math.hypot(...object.obb.size);
    const away = this.camera.position.clone().sub(center).normalize();
    if (away.lengthSq() === 0) away.set(0, 0, 1);
    const distance = (0.75 * size) / Math.tan((this.camera.fov * Math.PI) / 360);
    this.camera.position.copy(center).addScaledVector(away, distance);
    this.leavePhoto();
    this.navigation.lookAt(center);
  }

  pinhole(width: number, height: number): PinholePose {
    return pinholeOf(this.camera, this.root, width, height);
  }

  /** The object at a point of the canvas, in CSS pixels. */
  pick(x: number, y: number): { id: number; part: number } | null {
    const { cloud } = this;
    const pick = pickLabel(
      cloud.gaussians,
      (i) => (cloud.isVisible(i) ? cloud.objectOf(i) : -1),
      this.pinhole(this.width, this.height),
      x,
      y,
    );
    return pick && { id: pick.label, part: cloud.partOf(pick.gaussian) };
  }

  /** The mask of what is chosen: the photo's pixels at a photo, else the view's. */
  mask(): { width: number; height: number; mask: Uint8Array } {
    let camera = this.pinhole(this.width, this.height);
    if (this.photo) {
      const { scale, x, y } = photoRectangle(this.photo, this.width, this.height);
      camera = {
        ...camera,
        width: this.photo.width,
        height: this.photo.height,
        fx: camera.fx / scale,
        fy: camera.fy / scale,
        cx: (camera.cx - x) / scale,
        cy: (camera.cy - y) / scale,
      };
    }
    const mask = renderMask(
      this.cloud.gaussians,
      (i) => this.cloud.isVisible(i),
      (i) => this.cloud.isChosen(i),
      camera,
    );
    return { width: camera.width, height: camera.height, mask };
  }

  get width(): number {
    return Math.max(1, this.holder.clientWidth);
  }

  get height(): number {
    return Math.max(1, this.holder.clientHeight);
  }

  private toWorld(point: [number, number, number]): THREE.Vector3 {
    this.root.updateMatrixWorld();
    return new THREE.Vector3(...point).applyMatrix4(this.root.matrixWorld);
  }

  private leavePhoto(): void {
    if (!this.photo) return;
    this.photo = null;
    this.resize();
    this.photoListener();
  }

  private moved(): void {
    this.movedAt = performance.now();
    this.leavePhoto();
    this.redraw();
  }

  /** Spark makes its Gaussians anew only when they have changed. */
  private restore(): void {
    this.cloud.repaint();
    this.redraw();
  }

  private showChoice(): void {
    this.lit?.removeFromParent();
    this.lit?.geometry.dispose();
    this.lit = null;
    const choice = this.selection.choice;
    const object = this.scene.objects.find((o) => o.id === choice?.id);
    if (object && !choice?.region && !object.background && !this.selection.isolated) {
      this.lit = boxLines([object]);
      this.root.add(this.lit);
    }
    this.redraw();
  }

  private resize(): void {
    if (this.photo) {
      projectLikePhoto(this.camera, this.photo, this.width, this.height);
    } else {
      projectFreely(this.camera, this.width, this.height);
    }
    this.setResolution(this.resolution);
  }

  private setResolution(resolution: number): void {
    this.resolution = resolution;
    this.renderer.setPixelRatio(resolution * Math.min(devicePixelRatio, 2));
    this.renderer.setSize(this.width, this.height, false);
    this.redraw();
  }

  /** Leaves out more while frames take too long; at rest nothing. */
  private adapt(elapsed: number): void {
    const still = performance.now() - this.movedAt;
    if (still > Math.max(REST_MILLISECONDS, 1.5 * elapsed)) {
      this.applyStep(0);
      return;
    }
    if (this.drewLastTick && elapsed > SLOW_MILLISECONDS) {
      this.step = Math.min(this.step + 1, STEPS.length - 1);
      this.fastFrames = 0;
    } else if (elapsed < FAST_MILLISECONDS && ++this.fastFrames > FAST_FRAMES) {
      this.step = Math.max(this.step - 1, 0);
      this.fastFrames = 0;
    }
    this.applyStep(this.step);
  }

  private applyStep(step: number): void {
    if (step === this.drawnStep) return;
    const { resolution, fewer } = STEPS[step];
    this.cloud.showFewer(fewer);
    if (resolution !== STEPS[this.drawnStep].resolution) this.setResolution(resolution);
    this.drawnStep = step;
    this.redraw();
  }

  private tick(now: number): void {
    const elapsed = now - this.lastFrame;
    this.lastFrame = now;
    this.navigation.tick(elapsed / 1000);
    this.adapt(elapsed);
    this.drewLastTick = this.dirty;
    if (!this.dirty) return;
    this.dirty = false;
    this.spark.autoUpdate =
      this.drawnStep === 0 || now - this.lastUpdate > UPDATE_MILLISECONDS;
    if (this.spark.autoUpdate) this.lastUpdate = now;
    this.renderer.render(this.world, this.camera);
    const { times } = this.statistics;
    times.push(now);
    if (times.length > 100) times.shift();
    if (this.cloud.gaussians.count === this.scene.num_gaussians) {
      this.statistics.first ??= performance.now();
    }
  }
}
