// SPDX-License-Identifier: BSD-3-Clause
// The course of the training, drawn by uPlot.

import uPlot from "uplot";

import { element } from "./dom";

/** Columns of equal length; null where nothing was measured. */
export interface TrainingCurve {
  iteration: number[];
  loss: (number | null)[];
  holdout_psnr: (number | null)[];
  num_gaussians: (number | null)[];
}

const CHARTS: [keyof TrainingCurve, string, number][] = [
  ["loss", "Loss", 4],
  ["holdout_psnr", "Holdout PSNR, dB", 2],
  ["num_gaussians", "Gaussians", 0],
];

export class TrainingCharts {
  private plots: uPlot[] = [];

  constructor(private readonly holder: HTMLElement) {
    new ResizeObserver(() => {
      for (const plot of this.plots) plot.setSize(this.size(plot.root.parentElement!));
    }).observe(holder);
  }

  draw(curve: TrainingCurve): void {
    for (const plot of this.plots) plot.destroy();
    this.plots = [];
    this.holder.replaceChildren();
    for (const [key, title, decimals] of CHARTS) {
      const values = curve[key];
      if (values.filter((value) => value !== null).length < 2) continue;
      const figure = element("figure", { class: "v-chart" });
      figure.append(element("figcaption", {}, title));
      this.holder.append(figure);
      this.plots.push(this.plot(figure, curve.iteration, values, decimals));
    }
    if (this.plots.length === 0) {
      this.holder.append(
        element("p", { class: "quiet" }, "The course of the training is not there."),
      );
    }
  }

  private size(figure: HTMLElement) {
    return { width: Math.max(200, figure.clientWidth), height: 170 };
  }

  private plot(
    figure: HTMLElement,
    x: number[],
    y: (number | null)[],
    decimals: number,
  ): uPlot {
    const style = getComputedStyle(document.documentElement);
    const color = (name: string) => style.getPropertyValue(name).trim();
    const text = (value: number | null) =>
      value === null
        ? "–"
        : value.toLocaleString("en", {
            minimumFractionDigits: decimals,
            maximumFractionDigits: decimals,
          });
    const axis = {
      stroke: color("--quiet"),
      grid: { stroke: color("--line"), width: 1 },
      ticks: { show: false },
      font: "11px system-ui, sans-serif",
    };
    return new uPlot(
      {
        ...this.size(figure),
        legend: { live: true },
        scales: { x: { time: false } },
        axes: [
          { ...axis, space: 60 },
          {
            ...axis,
            size: 56,
            values: (_plot, ticks) => ticks.map((tick) => tick.toLocaleString("en")),
          },
        ],
        series: [
          { label: "Iteration" },
          {
            label: "Value",
            stroke: color("--accent"),
            width: 1.8,
            spanGaps: true,
            points: { show: false },
            value: (_plot, value) => text(value),
          },
        ],
      },
      [x, y] as uPlot.AlignedData,
      figure,
    );
  }
}
