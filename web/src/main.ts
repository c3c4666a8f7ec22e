// SPDX-License-Identifier: BSD-3-Clause
// Brings the report to life. The page has, where it has them,
//   #scene3d    a place for the 3D view, with a text that stays without it
//   #curves     JSON of the training, and #training, a place for its charts
//   #live       a place for the progress of a run
// It works from the file system, and through `freegs_pipeline view`.

import "uplot/dist/uPlot.min.css";
import "./style.css";
import { TrainingCharts, type TrainingCurve } from "./charts";
import { element } from "./dom";
import { LivePanel, readStatus } from "./live";
import { hasServedScene, openEmbeddedScene, openServedScene } from "./scene_data";
import { startViewer } from "./viewer";

function hasWebGl2(): boolean {
  return document.createElement("canvas").getContext("webgl2") !== null;
}

async function showScene(holder: HTMLElement, served: boolean): Promise<void> {
  const explain = (text: string) => {
    holder.replaceChildren(element("p", { class: "quiet", role: "status" }, text));
    holder.dataset.failed = text;
  };
  if (!hasWebGl2()) {
    explain(
      "There is no 3D view: this browser has no WebGL 2, or it is turned off. " +
        "The pictures below show the scene.",
    );
    return;
  }
  try {
    const source =
      (served ? await openServedScene() : null) ??
      (await openEmbeddedScene(holder.dataset.scene ?? "scene.js"));
    await startViewer(holder, source, served).loaded;
  } catch (error) {
    console.error(error);
    explain(`There is no 3D view: ${error instanceof Error ? error.message : error}`);
  }
}

function drawTraining(): void {
  const data = document.getElementById("curves");
  const holder = document.getElementById("training");
  if (!data || !holder) return;
  new TrainingCharts(holder).draw(JSON.parse(data.textContent ?? "") as TrainingCurve);
}

async function start(): Promise<void> {
  drawTraining();
  const status = await readStatus();
  const live = document.getElementById("live");
  if (status && live) void new LivePanel(live).follow(status);
  const holder = document.getElementById("scene3d");
  if (!holder) return;
  // The page of a run shows the scene where it is there before the report.
  if (holder.hidden) {
    if (!status || !(await hasServedScene())) return;
    holder.hidden = false;
  }
  await showScene(holder, status !== null);
}

void start();
