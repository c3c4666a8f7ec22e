// SPDX-License-Identifier: BSD-3-Clause
// Figures and keys as a person reads them.

import { keyText } from "./results";
import type { Cell, Spread } from "./results";

export function escapeHtml(text: string): string {
  const entities: Record<string, string> = {
    "&": "&amp;",
    "<": "&lt;",
    ">": "&gt;",
    '"': "&quot;",
    "'": "&#39;",
  };
  return text.replace(/[&<>"']/g, (character) => entities[character]);
}

/** A number with about three digits, and a unit where the name has one. */
export function formatFigure(name: string, value: number): string {
  if (/bytes$/.test(name)) {
    const units = ["B", "kB", "MB", "GB", "TB"];
    let size = value;
    let unit = 0;
    while (Math.abs(size) >= 1000 && unit < units.length - 1) {
      size /= 1000;
      ++unit;
    }
    return `${Number(size.toPrecision(3))} ${units[unit]}`;
  }
  if (Number.isInteger(value) && Math.abs(value) < 1e9) {
    return value.toLocaleString("en");
  }
  const size = Math.abs(value);
  if (size >= 1000 && size < 1e9) {
    return Math.round(value).toLocaleString("en");
  }
  return String(Number(value.toPrecision(size >= 1 && size < 100 ? 4 : 3)));
}

/**
 * The mean and its range: "3 (2 to 4)". Where it is of fewer than `runs` runs
 * this is said, too: "3 (2 to 4; 2 of 3)".
 */
export function formatSpread(
  name: string,
  spread: Spread,
  runs = spread.count,
): string {
  const mean = formatFigure(name, spread.mean);
  const min = formatFigure(name, spread.min);
  const max = formatFigure(name, spread.max);
  const notes = [
    min === max ? "" : `${min} to ${max}`,
    spread.count < runs ? `${spread.count} of ${runs}` : "",
  ].filter((note) => note !== "");
  return notes.length > 0 ? `${mean} (${notes.join("; ")})` : mean;
}

/** "sh_degree 2" for reconstruct.sh_degree; scenes and grids without a key. */
function keyPart(cell: Cell, key: string): string {
  const text = keyText(cell, key);
  if (key === "scene" || key === "grid" || key === "preset") return text;
  if (text === "") return "";
  return `${key.slice(key.lastIndexOf(".") + 1)} ${text}`;
}

/** What tells a cell from others: those of the keys that vary among `all`. */
export function keyWords(cell: Cell, keys: string[], all: Cell[]): string {
  const varying = keys.filter(
    (key) => new Set(all.map((other) => keyText(other, key))).size > 1,
  );
  const words = (varying.length > 0 ? varying : keys.slice(0, 1))
    .map((key) => keyPart(cell, key))
    .filter((word) => word !== "");
  return words.join(", ");
}

/** How an axis is called. */
export function axisName(name: string): string {
  const units: [RegExp, string][] = [
    [/psnr/, "dB"],
    [/rotation_deg/, "degrees"],
  ];
  const unit = units.find(([pattern]) => pattern.test(name));
  return name.replace(/_/g, " ") + (unit ? `, ${unit[1]}` : "");
}
