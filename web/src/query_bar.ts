// SPDX-License-Identifier: BSD-3-Clause
// Questions to the server of `freegs_pipeline view`: words, and pictures of
// what is sought.

import { button, element } from "./dom";
import { objectName } from "./object_panel";
import { servedAddress, type SceneDescription } from "./scene_data";
import type { Selection } from "./selection";

// The server takes 8 MB; larger pictures are made smaller first.
const MAX_SIDE = 1024;

interface Answer {
  found: boolean;
  score: string;
  threshold: number;
  hits: { id: number; score: number }[];
  others: { id: number; score: number }[];
  best_score: number | null;
  /** What `query` says on standard error: doubts about the answer. */
  note: string;
  timings?: { encode_ms: number; query_ms: number };
}

async function ask(scene: SceneDescription, body: object): Promise<Answer> {
  const answer = await fetch(servedAddress(scene, "/api/query"), {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(body),
  });
  const result = await answer.json();
  if (!answer.ok) throw new Error(result.error ?? `error ${answer.status}`);
  return result as Answer;
}

async function toBase64(file: Blob): Promise<string> {
  const bitmap = await createImageBitmap(file);
  const scale = Math.min(1, MAX_SIDE / Math.max(bitmap.width, bitmap.height));
  const canvas = document.createElement("canvas");
  canvas.width = Math.max(1, Math.round(scale * bitmap.width));
  canvas.height = Math.max(1, Math.round(scale * bitmap.height));
  canvas.getContext("2d")?.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
  return canvas.toDataURL("image/png").split(",")[1];
}

async function questionByPicture(file: Blob): Promise<object> {
  try {
    return { example: await toBase64(file) };
  } catch {
    throw new Error("This file is no picture that the browser can read.");
  }
}

export class QueryBar {
  readonly root: HTMLElement;
  private readonly answer = element("div", { class: "v-answer", role: "status" });
  /** Questions so far: only the latest one may be answered. */
  private turn = 0;

  constructor(
    private readonly scene: SceneDescription,
    private readonly selection: Selection,
  ) {
    const words = element("input", {
      type: "text",
      placeholder: "Ask in words: red apple",
      "aria-label": "Words that say what is sought",
      maxlength: "200",
    });
    const file = element("input", {
      type: "file",
      accept: "image/png,image/jpeg",
      class: "v-hide",
      tabindex: "-1",
      "aria-label": "Picture of what is sought",
      change: () => {
        if (file.files?.[0]) void this.ask(questionByPicture(file.files[0]));
        file.value = "";
      },
    });
    const form = element(
      "form",
      {
        class: "v-query",
        submit: (event) => {
          event.preventDefault();
          const text = words.value.trim();
          if (text) void this.ask(Promise.resolve({ text }));
        },
      },
      words,
      element("button", { type: "submit" }, "Ask"),
      button("Picture…", "Ask with a picture, or drop one on the page", () =>
        file.click(),
      ),
      file,
    );
    this.root = element("div", {}, form, this.answer);
    document.addEventListener("dragover", (event) => event.preventDefault());
    document.addEventListener("drop", (event) => {
      event.preventDefault();
      const dropped = event.dataTransfer?.files[0];
      if (dropped) void this.ask(questionByPicture(dropped));
    });
  }

  private async ask(question: Promise<object>): Promise<void> {
    const turn = ++this.turn;
    this.answer.textContent = "…";
    try {
      const body = { ...(await question), max_hits: 3 };
      const start = performance.now();
      const answer = await ask(this.scene, body);
      if (turn === this.turn) this.show(answer, performance.now() - start);
    } catch (error) {
      if (turn !== this.turn) return;
      this.answer.textContent = error instanceof Error ? error.message : String(error);
    }
  }

  private show(answer: Answer, milliseconds: number): void {
    const time = element("span", { class: "quiet" }, ` ${Math.round(milliseconds)} ms`);
    this.root.dataset.milliseconds = String(Math.round(milliseconds));
    if (!answer.found) {
      this.answer.replaceChildren("Nothing in the scene is like that.", time);
    } else {
      this.answer.replaceChildren();
    }
    const best = answer.found ? answer.hits : answer.others.slice(0, 3);
    for (const { id, score } of best) {
      const object = this.scene.objects.find((o) => o.id === id);
      if (!object) continue;
      this.answer.append(
        button(
          `${objectName(object)} (${answer.score} ${score.toFixed(2)})`,
          "Choose it",
          () => this.selection.choose(id),
        ),
      );
    }
    this.answer.append(time);
    // The name of the command before each line is for the terminal.
    const note = answer.note.replace(/^query: /gm, "").trim();
    if (note) this.answer.append(element("p", { class: "v-note" }, note));
    this.root.dataset.best = answer.found ? String(answer.hits[0].id) : "";
    if (answer.found) this.selection.choose(answer.hits[0].id);
  }
}
