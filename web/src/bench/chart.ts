// SPDX-License-Identifier: BSD-3-Clause
// A chart of a suite as an option of Apache ECharts: points with their spread,
// the Pareto front, and a strip below the axis for what failed. It needs no
// page, so that plot.mjs draws the same as an SVG.

import { CustomChart, LineChart, ScatterChart } from "echarts/charts";
import {
  GridComponent,
  LegendComponent,
  TitleComponent,
  TooltipComponent,
} from "echarts/components";
import * as echarts from "echarts/core";
import { SVGRenderer } from "echarts/renderers";

import { axis, axisRange } from "./axes";
import {
  figure,
  keyText,
  lessIsBetter,
  paretoFront,
  pointsOf,
  spread,
} from "./results";
import type { Cell, Chart, Point, Results } from "./results";
import { failureTooltip, pointTooltip } from "./tooltips";
import { keyWords } from "./words";

echarts.use([
  CustomChart,
  LineChart,
  ScatterChart,
  GridComponent,
  LegendComponent,
  TitleComponent,
  TooltipComponent,
  SVGRenderer,
]);

export { echarts };

const colors = [
  "#1b6ca8",
  "#d98200",
  "#2a9d5c",
  "#8e44ad",
  "#c0392b",
  "#3aa6a6",
  "#7a5230",
  "#555555",
  "#b5489b",
  "#8a9a1b",
  "#1f3a93",
  "#d9796a",
];
const presetSymbols: Record<string, string> = {
  fast: "triangle",
  balanced: "circle",
  quality: "diamond",
};
const legendGap = 18;

/** How high a legend of these names is, in pixels, on a page of usual width. */
function legendHeight(names: string[]): number {
  const [width, symbol, letter, line] = [860, 30, 6.6, 14];
  let rows = 1;
  let used = 0;
  for (const name of names) {
    const item = symbol + letter * name.length;
    if (used > 0 && used + item > width) {
      rows += 1;
      used = 0;
    }
    used += item + legendGap;
  }
  return rows * (line + legendGap);
}

const manyPoints = 25; // A series of more is a curve without dots.

/** Bars over the range of both figures. */
function errorBars(points: Point[], color: string, name: string) {
  return {
    type: "custom" as const,
    name,
    silent: true,
    z: 1,
    itemStyle: { color },
    data: points
      .filter(({ x, y }) => x!.count > 1 && y!.count > 1)
      .map(({ x, y }) => [x!.mean, y!.mean, x!.min, x!.max, y!.min, y!.max]),
    encode: { x: [0, 2, 3], y: [1, 4, 5] },
    renderItem: (
      _: unknown,
      api: { value(i: number): number; coord(at: number[]): number[] },
    ) => {
      const [x, y, x0, x1, y0, y1] = [0, 1, 2, 3, 4, 5].map((i) => api.value(i));
      const line = (from: number[], to: number[]) => {
        const [ax, ay] = api.coord(from);
        const [bx, by] = api.coord(to);
        return {
          type: "line",
          shape: { x1: ax, y1: ay, x2: bx, y2: by },
          style: { stroke: color, lineWidth: 1.5, opacity: 0.55 },
        };
      };
      return {
        type: "group",
        children: [line([x0, y], [x1, y]), line([x, y0], [x, y1])],
      };
    },
  };
}

function pointSeries(
  name: string,
  points: Point[],
  color: string,
  chart: Chart,
  results: Results,
) {
  // A line means that one thing was varied.
  const keys = ["scene", "grid", ...results.keys, "seed"].filter(
    (key) => new Set(points.map(({ cells }) => keyText(cells[0], key))).size > 1,
  );
  const line = chart.lines !== false && keys.length <= 1;
  const curve = line && points.length > manyPoints;
  return {
    type: "line" as const,
    name,
    color,
    symbolSize: curve ? 0 : 9,
    showSymbol: !curve,
    lineStyle: {
      width: line ? (curve ? 2 : 1) : 0,
      opacity: curve ? 1 : 0.5,
    },
    emphasis: { focus: "series" as const },
    labelLayout: { hideOverlap: true, moveOverlap: "shiftY" as const },
    data: points.map((point) => {
      const cell = point.cells[0];
      const preset = cell.point.preset ?? "";
      const label = chart.label ? keyText(cell, chart.label) : preset;
      return {
        value: [point.x!.mean, point.y!.mean],
        symbol: presetSymbols[preset] ?? "circle",
        tip: pointTooltip(point, chart, results),
        label: {
          show: label !== "" && !curve,
          formatter: () => label,
          position: "right" as const,
          color: "#444",
          fontSize: 11,
        },
      };
    }),
  };
}

function frontSeries(points: Point[], chart: Chart, name: string) {
  const less = chart.better ? chart.better === "lower" : lessIsBetter(chart.y);
  return {
    type: "line" as const,
    name,
    color: "#999",
    symbol: "none",
    step: "end" as const,
    silent: true,
    z: 0,
    lineStyle: { type: "dashed" as const, width: 1.5 },
    data: paretoFront(points, less).map(({ x, y }) => [x!.mean, y!.mean]),
  };
}

/** The option of ECharts for a chart of the results. */
export function chartOption(results: Results, chart: Chart) {
  const all = pointsOf(results, chart);
  const points = all
    .filter((point) => point.x && point.y)
    .sort((a, b) => a.x!.mean - b.x!.mean);
  const failed = all.flatMap((point) => point.failed);
  const cells = all.flatMap((point) => point.cells);

  const failedX = failed
    .map((cell) => figure(cell, chart.x))
    .filter((x): x is number => x !== null && (!chart.log_x || x > 0));
  const xRange = axisRange(
    [...points.flatMap(({ x }) => [x!.min, x!.max]), ...failedX],
    chart.log_x,
  );
  const yRange = axisRange(
    points.flatMap(({ y }) => [y!.min, y!.max]),
    chart.log_y,
  );

  const names = new Map<string, Point[]>();
  for (const point of points) {
    const name = keyWords(point.cells[0], chart.series, cells);
    names.set(name, [...(names.get(name) ?? []), point]);
  }
  const series: object[] = [];
  [...names].forEach(([name, members], i) => {
    const color = colors[i % colors.length];
    series.push(pointSeries(name, members, color, chart, results));
    series.push(errorBars(members, color, name));
  });
  const frontName = "Pareto front";
  if (chart.front !== false && points.length > 1) {
    // One front for each scene: scenes are not alternatives.
    const apart = chart.over.includes("scene") ? [] : ["scene"];
    const fronts = new Map<string, Point[]>();
    for (const point of points) {
      const key = apart.map((name) => keyText(point.cells[0], name)).join();
      fronts.set(key, [...(fronts.get(key) ?? []), point]);
    }
    for (const members of fronts.values()) {
      series.push(frontSeries(members, chart, frontName));
    }
  }
  if (failed.length > 0) {
    series.push({
      type: "scatter",
      name: "failed",
      xAxisIndex: 1,
      yAxisIndex: 1,
      symbol: "path://M2 0L5 3L8 0L10 2L7 5L10 8L8 10L5 7L2 10L0 8L3 5L0 2Z",
      symbolSize: 11,
      color: "#c0392b",
      data: failed.map((cell) => {
        const x = figure(cell, chart.x);
        return {
          value: [x !== null && (!chart.log_x || x > 0) ? x : xRange.min, 0],
          label: {
            show: chart.label !== "",
            formatter: () => keyText(cell, chart.label),
            position: "right" as const,
            color: "#444",
            fontSize: 11,
          },
          tip: failureTooltip(cell, chart),
        };
      }),
    });
  }
  const without =
    cells.filter((cell) => cell.status === "done").length -
    points.reduce((sum, { x }) => sum + x!.count, 0);
  const notes = [
    failed.length > 0 ? `${failed.length} failed` : "",
    without > 0 ? `${without} without a figure` : "",
  ].filter((note) => note !== "");

  const strip = failed.length > 0;
  const bottom = strip ? 96 : 56;
  const legendTop = notes.length > 0 ? 52 : 36;
  const shown = [
    ...new Set(series.map((one) => (one as { name?: string }).name ?? "")),
  ];
  const top = Math.max(96, legendTop + legendHeight(shown) + 8);
  return {
    animation: false,
    backgroundColor: "#ffffff",
    title: {
      text: chart.title,
      subtext: notes.join(", "),
      left: 16,
      top: 8,
      textStyle: { fontSize: 15, fontWeight: "normal" as const },
    },
    legend: {
      itemGap: legendGap,
      type: "plain" as const,
      top: legendTop,
      left: 16,
    },
    tooltip: {
      trigger: "item" as const,
      confine: true,
      extraCssText: "max-width:36rem;white-space:normal;overflow-wrap:anywhere",
      formatter: (item: { data?: { tip?: string } }) => item.data?.tip ?? "",
    },
    grid: [
      { left: 76, right: 60, top, bottom },
      ...(strip ? [{ left: 76, right: 60, height: 26, bottom: 56 }] : []),
    ],
    xAxis: [
      {
        ...axis(chart.x, chart.x_name, xRange, chart.log_x, 0),
        nameGap: 30,
        ...(strip ? { name: "", axisLabel: { show: false } } : {}),
      },
      ...(strip
        ? [{ ...axis(chart.x, chart.x_name, xRange, chart.log_x, 1), nameGap: 30 }]
        : []),
    ],
    yAxis: [
      { ...axis(chart.y, chart.y_name, yRange, chart.log_y, 0), nameGap: 54 },
      ...(strip
        ? [
            {
              gridIndex: 1,
              type: "value" as const,
              min: -1,
              max: 1,
              name: "failed",
              nameLocation: "middle" as const,
              nameRotate: 0,
              nameGap: 26,
              axisLabel: { show: false },
              axisTick: { show: false },
              splitLine: { show: false },
              axisLine: { show: true, onZero: false },
            },
          ]
        : []),
    ],
    series,
  };
}

/**
 * The range of a figure over the cells, for tables. A run that failed ended in
 * the middle of a stage and did not reach others, so its figures count only
 * where no cell is done.
 */
export function cellSpread(cells: Cell[], name: string) {
  const done = cells.filter((cell) => cell.status === "done");
  const taken = done.length > 0 ? done : cells;
  return spread(
    taken.map((cell) => cell.values[name]).filter((value) => value !== undefined),
  );
}
