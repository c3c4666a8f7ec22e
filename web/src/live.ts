// SPDX-License-Identifier: BSD-3-Clause
// What the server of `freegs_pipeline view` tells while a run is under way.

import { TrainingCharts, type TrainingCurve } from "./charts";
import { element } from "./dom";

interface StageState {
  name: string;
  state: string;
  wall_seconds: number | null;
}

export interface LiveStatus {
  live: true;
  workspace: string;
  running: boolean;
  stages: StageState[];
  progress: {
    stage: string;
    step: string;
    done: number;
    total: number;
    seconds_left: number | null;
  } | null;
  curve: TrainingCurve;
  preview: string | null;
  export_version: string;
  scene_version: string;
}

const POLL_MILLISECONDS = 2000;

/** Null where the page was not opened through `view`. */
export async function readStatus(): Promise<LiveStatus | null> {
  if (!location.protocol.startsWith("http")) return null;
  try {
    const answer = await fetch("/api/status");
    if (!answer.ok) return null;
    const status = (await answer.json()) as LiveStatus;
    return status.live === true ? status : null;
  } catch {
    return null;
  }
}

function seconds(time: number): string {
  return time < 90 ? `${Math.round(time)} s` : `${Math.round(time / 60)} min`;
}

export class LivePanel {
  private readonly bar = element("progress", { "aria-label": "Progress", max: "1" });
  private readonly line = element("p", { role: "status" });
  private readonly stages = element("ol", { class: "v-stages" });
  private readonly preview = element("img", {
    class: "v-preview",
    alt: "A view of the scene as far as it is trained",
  });
  private readonly chartHolder = element("div", { class: "charts" });
  private readonly charts = new TrainingCharts(this.chartHolder);
  private drawn = "";

  constructor(private readonly holder: HTMLElement) {
    this.preview.hidden = true;
    holder.append(
      this.line,
      this.bar,
      this.stages,
      element("div", { class: "v-live" }, this.preview, this.chartHolder),
    );
  }

  /**
   * Shows a run until it has ended; then the page is loaded anew. So it is when
   * only the scene is another: answers would be about objects not shown here.
   */
  async follow(first: LiveStatus): Promise<void> {
    const version = (status: LiveStatus) =>
      `${status.export_version} ${status.scene_version}`;
    for (let status: LiveStatus | null = first; ; status = await readStatus()) {
      if (status) this.show(status);
      else this.line.textContent = "The server does not answer any more.";
      if (status && !status.running && version(status) !== version(first)) {
        location.href = "/";
        return;
      }
      await new Promise((resolve) => setTimeout(resolve, POLL_MILLISECONDS));
    }
  }

  private show(status: LiveStatus): void {
    const { progress } = status;
    this.holder.hidden = !status.running && status.export_version !== "";
    if (progress) {
      const left =
        progress.seconds_left === null
          ? ""
          : `, ${seconds(progress.seconds_left)} left`;
      const part = progress.total > 0 ? ` ${progress.done} of ${progress.total}` : "";
      this.line.textContent = `${progress.stage}: ${progress.step}${part}${left}`;
      if (progress.total > 0) this.bar.value = progress.done / progress.total;
      else this.bar.removeAttribute("value");
    } else {
      this.line.textContent = status.running
        ? "A run is under way."
        : "No run is under way here.";
      if (status.running) this.bar.removeAttribute("value");
    }
    this.bar.hidden = !status.running;
    this.stages.replaceChildren(
      ...status.stages.map((stage) =>
        element(
          "li",
          { "data-state": stage.state },
          `${stage.name}: ${stage.state}`,
          stage.wall_seconds === null ? null : ` in ${seconds(stage.wall_seconds)}`,
        ),
      ),
    );
    this.preview.hidden = status.preview === null;
    if (status.preview && this.preview.getAttribute("src") !== status.preview) {
      this.preview.src = status.preview;
    }
    const curve = JSON.stringify(status.curve);
    if (curve !== this.drawn) {
      this.drawn = curve;
      this.charts.draw(status.curve);
    }
  }
}
