// SPDX-License-Identifier: BSD-3-Clause
// The page of a bench: charts that tell more under the pointer, tables, and
// every cell.

import { chartOption, cellSpread, echarts } from "./chart";
import { grouped, keyText, selected, words } from "./results";
import type { Cell, Results, Table } from "./results";
import { formatFigure, formatSpread } from "./words";

function add<K extends keyof HTMLElementTagNameMap>(
  parent: HTMLElement,
  tag: K,
  text = "",
  className = "",
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  element.textContent = text;
  if (className) element.className = className;
  parent.append(element);
  return element;
}

function startTable(parent: HTMLElement, columns: string[]) {
  const scroll = add(parent, "div", "", "scroll");
  scroll.tabIndex = 0; // So that keys scroll it.
  const table = add(scroll, "table");
  const head = add(add(table, "thead"), "tr");
  for (const column of columns) add(head, "th", column);
  return add(table, "tbody");
}

function addTable(parent: HTMLElement, table: Table, results: Results) {
  const cells = selected(results.cells, table);
  const keys = ["scene", "grid", ...results.keys, "seed"].filter(
    (key) =>
      !table.over.includes(key) &&
      (key === "scene" || new Set(cells.map((cell) => keyText(cell, key))).size > 1),
  );
  // The titles of means need a column; a key without a name has no values.
  if (keys.length === 0 && table.means.length > 0) keys.push("");
  add(parent, "h2", table.title);
  const body = startTable(parent, [...keys, ...table.columns]);
  const addRow = (titles: string[], group: Cell[]) => {
    const row = add(body, "tr");
    for (const title of titles) add(row, "td", title);
    for (const column of table.columns) {
      const text = words(group, column);
      if (text !== null) {
        add(row, "td", text, "reason");
        continue;
      }
      const values = cellSpread(group, column);
      const figures = values ? formatSpread(column, values, group.length) : "";
      add(row, "td", figures, "number");
    }
  };
  for (const group of grouped(cells, keys)) {
    addRow(
      keys.map((key) => keyText(group[0], key)),
      group,
    );
  }
  for (const { title, scenes } of table.means) {
    const blank = keys.slice(1).map(() => "");
    addRow(
      [title, ...blank],
      cells.filter((cell) => scenes.includes(cell.scene)),
    );
  }
}

function addCells(parent: HTMLElement, results: Results) {
  add(parent, "h2", "All experiments");
  const figures = [
    "total.wall_seconds",
    "total.cpu_seconds",
    "total.peak_memory_bytes",
    "total.bytes",
    "holdout_psnr",
    "instance_miou",
    "text_miou",
  ].filter((name) => results.cells.some((cell) => name in cell.values));
  const body = startTable(parent, [
    "scene",
    "grid",
    ...results.keys,
    "seed",
    "result",
    "poses",
    "what was said",
    ...figures,
  ]);
  for (const cell of results.cells) {
    const row = add(body, "tr", "", cell.status === "failed" ? "failed" : "");
    for (const key of ["scene", "grid", ...results.keys, "seed"]) {
      add(row, "td", keyText(cell, key));
    }
    const failed = cell.status === "failed";
    add(
      row,
      "td",
      failed ? `${cell.failed_stage}: exit code ${cell.exit_code}` : cell.status,
    );
    add(row, "td", cell.verdict);
    // Every line would end with the empty reason of a run that did not fail.
    const said = cell.said.filter(
      (line) => cell.reason === "" || !line.endsWith(cell.reason),
    );
    const lines = [cell.reason, ...said].filter((line) => line !== "");
    const lineCell = add(row, "td", "", lines.length > 0 ? "reason" : "");
    for (const line of lines) add(lineCell, "div", line);
    for (const name of figures) {
      const value = cell.values[name];
      const text = value === undefined ? "" : formatFigure(name, value);
      add(row, "td", text, "number");
    }
  }
}

function start() {
  const source = document.getElementById("results");
  const parent = document.getElementById("bench");
  if (!source || !parent) return;
  const results = JSON.parse(source.textContent ?? "") as Results;
  parent.replaceChildren();
  const { processor, cores } = results.machine;
  const cells = results.cells;
  const count = (status: string) =>
    cells.filter((cell) => cell.status === status).length;
  add(
    parent,
    "p",
    `${count("done")} of ${cells.length} experiments done` +
      (count("failed") > 0 ? `, ${count("failed")} failed` : "") +
      `; ${processor || "unknown processor"}, ${cores} cores; ` +
      `freegs_pipeline ${results.program_version}. ` +
      "Points are means, bars go from the least to the most; the dashed " +
      "line, the Pareto front, joins what nothing beats in both measures.",
    "quiet",
  );
  if (!results.one_program) {
    add(
      parent,
      "p",
      "These experiments are of more than one build of the program.",
      "warning",
    );
  }
  const charts = results.charts.map((chart) => {
    const element = add(parent, "div", "", "chart");
    element.dataset.chart = chart.name;
    const instance = echarts.init(element, null, { renderer: "svg" });
    instance.setOption(chartOption(results, chart));
    return instance;
  });
  for (const table of results.tables) addTable(parent, table, results);
  addCells(parent, results);
  const note = add(parent, "p", "The charts hold work of others: ", "quiet");
  const link = add(note, "a", "licences");
  link.href = "licenses.txt";
  window.addEventListener("resize", () => {
    for (const chart of charts) chart.resize();
  });
  // For tests.
  Object.assign(globalThis, { freegsBench: { results, charts } });
}

start();
