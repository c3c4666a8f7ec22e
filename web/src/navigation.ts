// SPDX-License-Identifier: BSD-3-Clause
// Turning around the scene and flying through it, by pointer, touch and keys.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const STEP = Math.PI / 36; // A key press turns by 5 degrees.
const KEY_ADVANCE = 0.1; // While flying, in radii of the scene.

export class Navigation {
  private readonly orbit: OrbitControls;
  private readonly held = new Set<string>();
  private flying = false;
  /** While flying: where the pointers that are down are. */
  private readonly pointers = new Map<number, THREE.Vector2>();

  constructor(
    private readonly camera: THREE.PerspectiveCamera,
    element: HTMLElement,
    private readonly radius: number,
    private readonly onMove: () => void,
  ) {
    this.orbit = new OrbitControls(camera, element);
    this.orbit.enableDamping = false;
    this.orbit.zoomToCursor = true;
    // What one comes near to has to stay beyond the near plane.
    this.orbit.minDistance = Math.max(0.02 * radius, 1.5 * camera.near);
    this.orbit.maxDistance = 20 * radius;
    this.orbit.addEventListener("change", onMove);
    element.addEventListener("keydown", (event) => this.keyDown(event));
    element.addEventListener("keyup", (event) => this.held.delete(event.code));
    element.addEventListener("blur", () => this.held.clear());
    element.addEventListener("pointerdown", (event) => {
      if (this.flying) this.pointers.set(event.pointerId, placeOf(event));
    });
    element.addEventListener("pointermove", (event) => this.drag(event));
    for (const end of ["pointerup", "pointercancel", "pointerleave"]) {
      element.addEventListener(end, (event) =>
        this.pointers.delete((event as PointerEvent).pointerId),
      );
    }
    element.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
  }

  get target(): THREE.Vector3 {
    return this.orbit.target;
  }

  setFlying(flying: boolean): void {
    this.flying = flying;
    this.pointers.clear();
    this.orbit.enabled = !flying;
    if (!flying) this.aim(this.camera.position.distanceTo(this.orbit.target));
  }

  /** Turns around a point so far in front of the camera from now on. */
  aim(distance: number): void {
    const forward = this.camera.getWorldDirection(new THREE.Vector3());
    this.orbit.target.copy(this.camera.position).addScaledVector(forward, distance);
  }

  /** Looks at a point from where the camera is. */
  lookAt(point: THREE.Vector3): void {
    this.orbit.target.copy(point);
    this.orbit.update();
    this.onMove();
  }

  /** Moves while keys are held; true if it did. */
  tick(seconds: number): boolean {
    const move = new THREE.Vector3(
      this.axis("KeyD", "KeyA"),
      this.axis("KeyE", "KeyQ"),
      this.axis("KeyS", "KeyW"),
    );
    if (move.lengthSq() === 0) return false;
    move
      .normalize()
      .multiplyScalar(0.5 * this.radius * Math.min(seconds, 0.1))
      .applyQuaternion(this.camera.quaternion);
    this.camera.position.add(move);
    this.orbit.target.add(move);
    this.onMove();
    return true;
  }

  private axis(positive: string, negative: string): number {
    return (this.held.has(positive) ? 1 : 0) - (this.held.has(negative) ? 1 : 0);
  }

  private keyDown(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (/^Key[WASDQE]$/.test(event.code)) {
      this.held.add(event.code);
      this.onMove();
      return;
    }
    const turn: Record<string, [number, number]> = {
      ArrowLeft: [-STEP, 0],
      ArrowRight: [STEP, 0],
      ArrowUp: [0, -STEP],
      ArrowDown: [0, STEP],
    };
    if (turn[event.key]) {
      if (this.flying) this.turn(...turn[event.key]);
      else this.circle(...turn[event.key]);
    } else if (event.key === "+" || event.key === "=") {
      if (this.flying) this.advance(KEY_ADVANCE * this.radius);
      else this.approach(0.9);
    } else if (event.key === "-") {
      if (this.flying) this.advance(-KEY_ADVANCE * this.radius);
      else this.approach(1 / 0.9);
    } else {
      return;
    }
    event.preventDefault();
    this.onMove();
  }

  private circle(azimuth: number, elevation: number): void {
    const offset = this.camera.position.clone().sub(this.orbit.target);
    const spherical = new THREE.Spherical().setFromVector3(offset);
    spherical.theta += azimuth;
    spherical.phi += elevation;
    spherical.makeSafe();
    this.camera.position.setFromSpherical(spherical).add(this.orbit.target);
    this.camera.lookAt(this.orbit.target);
  }

  private approach(factor: number): void {
    const offset = this.camera.position.clone().sub(this.orbit.target);
    const { minDistance, maxDistance } = this.orbit;
    const distance = THREE.MathUtils.clamp(
      factor * offset.length(),
      minDistance,
      maxDistance,
    );
    this.camera.position.copy(this.orbit.target).add(offset.setLength(distance));
  }

  private turn(yaw: number, pitch: number): void {
    const angles = new THREE.Euler().setFromQuaternion(this.camera.quaternion, "YXZ");
    angles.y -= yaw;
    angles.x = Math.min(1.5, Math.max(-1.5, angles.x - pitch));
    angles.z = 0;
    const distance = this.camera.position.distanceTo(this.orbit.target);
    this.camera.quaternion.setFromEuler(angles);
    this.aim(distance);
  }

  /** One pointer looks around; two move nearer or farther, as their distance does. */
  private drag(event: PointerEvent): void {
    const place = this.pointers.get(event.pointerId);
    if (!place) return;
    const before = place.clone();
    const apart = this.apart();
    place.copy(placeOf(event));
    if (this.pointers.size === 1) {
      this.turn(0.004 * (place.x - before.x), 0.004 * (place.y - before.y));
    } else {
      this.advance(this.radius * Math.log(this.apart() / apart));
    }
    this.onMove();
  }

  /** Pixels between the first two pointers, at least one. */
  private apart(): number {
    const [first, second] = this.pointers.values();
    return second ? Math.max(1, first.distanceTo(second)) : 1;
  }

  private wheel(event: WheelEvent): void {
    if (!this.flying) return;
    // Pixels, lines or pages.
    const pixels = event.deltaY * [1, 16, 100][event.deltaMode];
    this.advance(-0.0005 * this.radius * pixels);
    this.onMove();
    event.preventDefault();
  }

  /** Moves along the direction of view. */
  private advance(distance: number): void {
    const move = this.camera
      .getWorldDirection(new THREE.Vector3())
      .multiplyScalar(distance);
    this.camera.position.add(move);
    this.orbit.target.add(move);
  }
}

function placeOf(event: PointerEvent): THREE.Vector2 {
  return new THREE.Vector2(event.clientX, event.clientY);
}
