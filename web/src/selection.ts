// SPDX-License-Identifier: BSD-3-Clause
// What is chosen, hidden and coloured, and what that means for each Gaussian.

import { contains, regionAt } from "./levels";
import { NO_PART, type Interval, type SceneDescription, type Vec3 } from "./scene_data";

export interface Choice {
  id: number;
  /** The part that was clicked; NO_PART when chosen from the list. */
  part: number;
  /** Levels above the object, or below it where negative. */
  steps: number;
  /** Null for the object itself. */
  region: Interval | null;
}

type Listener = () => void;

const LIT: Vec3 = [255, 214, 64];
const DARK: Vec3 = [8, 8, 12];

export class Selection {
  choice: Choice | null = null;
  isolated = false;
  colored = false;
  readonly hidden = new Set<number>();
  private readonly listeners: Listener[] = [];
  private readonly colors = new Map<number, Vec3>();

  constructor(readonly scene: SceneDescription) {
    for (const object of scene.objects) this.colors.set(object.id, object.color);
  }

  onChange(listener: Listener): void {
    this.listeners.push(listener);
  }

  choose(id: number, part = NO_PART): void {
    this.choice = { id, part, steps: 0, region: null };
    this.hidden.delete(id);
    this.notify();
  }

  clear(): void {
    if (!this.choice && !this.isolated) return;
    this.choice = null;
    this.isolated = false;
    this.notify();
  }

  /** One level wider (1) or narrower (-1). False when there is none. */
  step(direction: 1 | -1): boolean {
    if (!this.choice) return false;
    const { id, part } = this.choice;
    const wanted = this.choice.steps + direction;
    const found = regionAt(this.scene.levels[id], part, wanted);
    if (found.steps !== wanted) return false;
    this.choice = { id, part, ...found };
    this.notify();
    return true;
  }

  canStep(direction: 1 | -1): boolean {
    if (!this.choice) return false;
    const wanted = this.choice.steps + direction;
    return (
      regionAt(this.scene.levels[this.choice.id], this.choice.part, wanted).steps ===
      wanted
    );
  }

  setIsolated(isolated: boolean): void {
    this.isolated = isolated && this.choice !== null;
    this.notify();
  }

  setColored(colored: boolean): void {
    this.colored = colored;
    this.notify();
  }

  setHidden(id: number, hidden: boolean): void {
    if (hidden) {
      this.hidden.add(id);
      if (this.choice?.id === id) {
        this.choice = null;
        this.isolated = false;
      }
    } else {
      this.hidden.delete(id);
    }
    this.notify();
  }

  showAll(): void {
    this.hidden.clear();
    this.isolated = false;
    this.notify();
  }

  isChosen(id: number, part: number): boolean {
    const choice = this.choice;
    if (!choice) return false;
    // What is wider has all of the object, also Gaussians of no part.
    if (id === choice.id && choice.steps >= 0) return true;
    return choice.region !== null && part !== NO_PART && contains(choice.region, part);
  }

  isVisible(id: number, part: number): boolean {
    if (this.isolated) return this.isChosen(id, part);
    return !this.hidden.has(id);
  }

  /**
   * Four bytes per Gaussian: a colour to mix in, and how much of it (254 is
   * all); 255 hides the Gaussian.
   */
  paint(labels: Uint16Array, state: Uint8Array): void {
    for (let i = 0; 2 * i < labels.length; ++i) {
      const id = labels[2 * i];
      const part = labels[2 * i + 1];
      let tint: Vec3 = DARK;
      let mix = 0;
      if (!this.isVisible(id, part)) {
        mix = 255;
      } else if (this.colored) {
        tint = this.colors.get(id) ?? [128, 128, 128];
        mix = id > 0 ? 165 : 120;
        if (this.choice && !this.isolated) {
          mix = 235;
          if (!this.isChosen(id, part)) {
            tint = [tint[0] >> 2, tint[1] >> 2, tint[2] >> 2];
          }
        }
      } else if (this.choice && !this.isolated) {
        if (this.isChosen(id, part)) {
          tint = LIT;
          mix = 70;
        } else {
          mix = 150;
        }
      }
      state[4 * i] = tint[0];
      state[4 * i + 1] = tint[1];
      state[4 * i + 2] = tint[2];
      state[4 * i + 3] = mix;
    }
  }

  private notify(): void {
    for (const listener of this.listeners) listener();
  }
}
