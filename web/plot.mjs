// SPDX-License-Identifier: BSD-3-Clause
// Draws a chart as an SVG, by the same code as the page of a bench:
//
//   node plot.mjs results.json --chart NAME --out X.svg
//   node plot.mjs NAME=TABLE.csv ... --x COLUMN --y COLUMN --title T --out X.svg
//     [--label COLUMN] [--log-x] [--log-y] [--x-name TEXT] [--y-name TEXT]
//
// The first draws a chart of a suite (docs/bench.md). The second draws a line
// for each table; with --label the text of that column stands beside each
// point, and rows without a number in --y are shown as failed. --width and
// --height are in pixels. It needs the packages of package.json, so the copy in
// the folder web/ of the build is the one to run.

import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";

import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));

/** The page's chart code as a module. */
async function loadCharts() {
  const bundle = await build({
    absWorkingDir: here,
    entryPoints: ["src/bench/chart.ts"],
    bundle: true,
    format: "esm",
    platform: "node",
    write: false,
    logLevel: "warning",
  });
  const source = Buffer.from(bundle.outputFiles[0].contents).toString("base64");
  return import(`data:text/javascript;base64,${source}`);
}

/** The rows of a CSV (RFC 4180) as objects; lines without a comma are left out. */
function readCsv(path) {
  const rows = [[""]];
  let quoted = false;
  const text = readFileSync(path, "utf8").replace(/\r\n/g, "\n");
  for (let i = 0; i < text.length; ++i) {
    const row = rows.at(-1);
    const c = text[i];
    if (quoted && c === '"' && text[i + 1] === '"') row[row.length - 1] += text[++i];
    else if (c === '"') quoted = !quoted;
    else if (c === "," && !quoted) row.push("");
    else if (c === "\n" && !quoted) rows.push([""]);
    else row[row.length - 1] += c;
  }
  const [names, ...lines] = rows.filter((row) => row.length > 1);
  return lines.map((row) =>
    Object.fromEntries(names.map((name, i) => [name, row[i] ?? ""])),
  );
}

/** Tables as results with one chart. */
function resultsOfTables(tables, values) {
  const cells = tables.flatMap((argument) => {
    const [name, path] = argument.split(/=(.*)/s);
    return readCsv(path).map((row, i) => {
      const numbers = Object.entries(row).filter(
        ([, text]) => text !== "" && Number.isFinite(Number(text)),
      );
      const figures = Object.fromEntries(
        numbers.map(([key, text]) => [key, Number(text)]),
      );
      return {
        id: `${name}: ${values.label ? row[values.label] : i + 1}`,
        scene: name,
        grid: "",
        seed: 0,
        point: { ...row, row: String(i) },
        status: values.y in figures ? "done" : "failed",
        exit_code: 0,
        failed_stage: "",
        reason: "",
        values: figures,
      };
    });
  });
  const chart = {
    name: "chart",
    title: values.title ?? "",
    scenes: [],
    grids: [],
    over: [],
    x: values.x,
    y: values.y,
    series: ["scene"],
    label: values.label ?? "",
    log_x: values["log-x"] ?? false,
    log_y: values["log-y"] ?? false,
    better: "",
    x_name: values["x-name"],
    y_name: values["y-name"],
    front: false,
    lines: !values.label,
  };
  return { keys: ["row"], cells, charts: [chart] };
}

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    chart: { type: "string" },
    out: { type: "string" },
    x: { type: "string" },
    y: { type: "string" },
    title: { type: "string" },
    label: { type: "string" },
    "x-name": { type: "string" },
    "y-name": { type: "string" },
    "log-x": { type: "boolean" },
    "log-y": { type: "boolean" },
    width: { type: "string", default: "860" },
    height: { type: "string", default: "480" },
  },
});

function fail(message) {
  console.error(`plot.mjs: ${message}`);
  process.exit(2);
}

if (!values.out || positionals.length === 0) {
  fail("give results.json or NAME=TABLE.csv, and --out X.svg");
}
const ofTables = positionals.every((argument) => argument.includes("="));
if (ofTables && !(values.x && values.y)) fail("give --x and --y");
const results = ofTables
  ? resultsOfTables(positionals, values)
  : JSON.parse(readFileSync(positionals[0], "utf8"));
const chart = ofTables
  ? results.charts[0]
  : results.charts.find(({ name }) => name === values.chart);
if (!chart) {
  const names = results.charts.map(({ name }) => name).join(", ");
  fail(`--chart is one of: ${names}`);
}
const { chartOption, echarts } = await loadCharts();
const instance = echarts.init(null, null, {
  renderer: "svg",
  ssr: true,
  width: Number(values.width),
  height: Number(values.height),
});
instance.setOption(chartOption(results, chart));
writeFileSync(values.out, instance.renderToSVGString() + "\n");
instance.dispose();
