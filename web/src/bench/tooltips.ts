// SPDX-License-Identifier: BSD-3-Clause
// What a chart says under the pointer.

import { figure, keyText } from "./results";
import type { Cell, Chart, Point, Results } from "./results";
import { escapeHtml, formatSpread } from "./words";

/** Settings and figures of a point, as HTML. */
export function pointTooltip(point: Point, chart: Chart, results: Results): string {
  const cell = point.cells[0];
  const keys = ["scene", "grid", ...results.keys, "seed"]
    .filter((key) => !chart.over.includes(key) && keyText(cell, key) !== "")
    .map((key) => `${key} <b>${escapeHtml(keyText(cell, key))}</b>`);
  const lines = [
    keys.join("<br>"),
    `${escapeHtml(chart.x)} <b>${formatSpread(chart.x, point.x!)}</b>`,
    `${escapeHtml(chart.y)} <b>${formatSpread(chart.y, point.y!)}</b>`,
  ];
  const runs = point.cells.length;
  if (runs > 1) lines.push(`${point.x!.count} of ${runs} runs`);
  return lines.join("<br>");
}

/** Why a cell failed, as HTML. */
export function failureTooltip(cell: Cell, chart: Chart): string {
  const x = figure(cell, chart.x);
  return [
    `<b>${escapeHtml(cell.id)}</b>`,
    `failed in ${escapeHtml(cell.failed_stage)} with exit code ${cell.exit_code}`,
    escapeHtml(cell.reason),
    x === null ? `no ${escapeHtml(chart.x)}` : "",
  ]
    .filter((line) => line !== "")
    .join("<br>");
}
