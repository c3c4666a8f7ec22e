// SPDX-License-Identifier: BSD-3-Clause
// results.json of `freegs_pipeline bench`, and the points that a chart shows of
// it.

export interface Cell {
  id: string;
  scene: string;
  grid: string;
  seed: number;
  point: Record<string, string>;
  status: "waiting" | "done" | "failed";
  exit_code: number;
  failed_stage: string;
  reason: string;
  verdict: string;
  said: string[];
  ended: string;
  noticed: string;
  told: string;
  values: Record<string, number>;
  folder: string;
  log: string;
}

export interface Selection {
  name: string;
  title: string;
  scenes: string[];
  grids: string[];
  over: string[];
}

export interface Chart extends Selection {
  x: string;
  y: string;
  series: string[];
  label: string;
  log_x: boolean;
  log_y: boolean;
  better: string;
  x_name?: string; // How the axis is called; by the figure if it is not there.
  y_name?: string;
  front?: boolean; // Whether the Pareto front is drawn; it is unless false.
  lines?: boolean; // Whether points may be joined; they may unless false.
}

export interface Table extends Selection {
  columns: string[];
  means: { title: string; scenes: string[] }[];
}

export interface Results {
  title: string;
  seeds: number[];
  keys: string[];
  program_version: string;
  one_program: boolean;
  machine: { processor: string; cores: number; memory_bytes: number };
  charts: Chart[];
  tables: Table[];
  cells: Cell[];
}

/** Mean and range of a figure over some cells. */
export interface Spread {
  mean: number;
  min: number;
  max: number;
  count: number;
}

/** Cells that differ only in what the chart takes the mean over. */
export interface Point {
  cells: Cell[]; // All of them.
  x: Spread | null; // Of those that have both figures.
  y: Spread | null;
  failed: Cell[];
}

/** The value of a key: scene, grid, seed, or a key of the suite's grids. */
export function keyText(cell: Cell, key: string): string {
  if (key === "scene") return cell.scene;
  if (key === "grid") return cell.grid;
  if (key === "seed") return String(cell.seed);
  return cell.point[key] ?? "";
}

/** Words that a table may have as columns. */
const wordNames = [
  "ended",
  "status",
  "exit_code",
  "failed_stage",
  "reason",
  "verdict",
  "noticed",
  "told",
] as const;

/** The different words of some cells; null when the name is not that of words. */
export function words(cells: Cell[], name: string): string | null {
  const known = wordNames.find((word) => word === name);
  if (known === undefined) return null;
  const all = new Set(
    cells.map((cell) => String(cell[known])).filter((word) => word !== ""),
  );
  return [...all].join("; ");
}

/** A figure, or a key whose value is a number; null where there is none. */
export function figure(cell: Cell, name: string): number | null {
  const value = cell.values[name];
  if (value !== undefined) return value;
  const text = keyText(cell, name);
  const number = Number(text);
  return text !== "" && Number.isFinite(number) ? number : null;
}

export function spread(values: number[]): Spread | null {
  if (values.length === 0) return null;
  return {
    mean: values.reduce((sum, value) => sum + value, 0) / values.length,
    min: Math.min(...values),
    max: Math.max(...values),
    count: values.length,
  };
}

export function selected(cells: Cell[], selection: Selection): Cell[] {
  const takes = (names: string[], name: string) =>
    names.length === 0 || names.includes(name);
  return cells.filter(
    (cell) => takes(selection.scenes, cell.scene) && takes(selection.grids, cell.grid),
  );
}

/** Groups cells by the values of some keys, in their order. */
export function grouped(cells: Cell[], keys: string[]): Cell[][] {
  const groups = new Map<string, Cell[]>();
  for (const cell of cells) {
    const key = JSON.stringify(keys.map((name) => keyText(cell, name)));
    const group = groups.get(key);
    if (group) group.push(cell);
    else groups.set(key, [cell]);
  }
  return [...groups.values()];
}

export function pointsOf(results: Results, chart: Chart): Point[] {
  const keys = ["scene", "grid", ...results.keys, "seed"].filter(
    (key) => !chart.over.includes(key),
  );
  const allowed = (value: number | null, log: boolean) =>
    value !== null && (!log || value > 0);
  return grouped(selected(results.cells, chart), keys).map((cells) => {
    const shown = cells.filter(
      (cell) =>
        cell.status === "done" &&
        allowed(figure(cell, chart.x), chart.log_x) &&
        allowed(figure(cell, chart.y), chart.log_y),
    );
    const of = (name: string) =>
      spread(shown.map((cell) => figure(cell, name) as number));
    return {
      cells,
      x: of(chart.x),
      y: of(chart.y),
      failed: cells.filter((cell) => cell.status === "failed"),
    };
  });
}

/** Whether less of a figure is better, by its name. */
export function lessIsBetter(name: string): boolean {
  return /seconds|bytes|error|rotation|translation|crumbs|uncovered|gaussians/.test(
    name,
  );
}

/** The points that no other point beats in both x (less) and y. */
export function paretoFront(points: Point[], lessOfY: boolean): Point[] {
  const sign = lessOfY ? -1 : 1;
  const sorted = points
    .filter((point) => point.x && point.y)
    .sort((a, b) => a.x!.mean - b.x!.mean || sign * (b.y!.mean - a.y!.mean));
  const front: Point[] = [];
  for (const point of sorted) {
    const last = front.at(-1);
    if (!last || sign * (point.y!.mean - last.y!.mean) > 0) front.push(point);
  }
  return front;
}
