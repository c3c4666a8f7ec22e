// SPDX-License-Identifier: BSD-3-Clause
// Wholes and parts. A region is an interval of parts; a step wider or narrower
// means the same as in `freegs_pipeline query --click ... --wider N`.

import type { Interval, ObjectLevels } from "./scene_data";

/**
 * The region `steps` levels above the object (below it at this part for
 * negative steps), or null for the object itself. Steps end at the widest and
 * at the narrowest region there is; `steps` is how many could be taken.
 */
export function regionAt(
  levels: ObjectLevels | undefined,
  part: number,
  steps: number,
): { region: Interval | null; steps: number } {
  if (!levels || steps === 0) return { region: null, steps: 0 };
  if (steps > 0) {
    const taken = Math.min(steps, levels.wider.length);
    return {
      region: taken > 0 ? levels.wider[taken - 1] : null,
      steps: taken,
    };
  }
  const nested = levels.narrower
    .filter((region) => contains(region, part))
    .sort((a, b) => b[1] - b[0] - (a[1] - a[0]));
  const taken = Math.min(-steps, nested.length);
  return {
    region: taken > 0 ? nested[taken - 1] : null,
    steps: taken > 0 ? -taken : 0,
  };
}

export function contains(region: Interval, part: number): boolean {
  return region[0] <= part && part < region[1];
}
