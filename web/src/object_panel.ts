// SPDX-License-Identifier: BSD-3-Clause
// The list of objects, and what is known of the one that is chosen.

import { button, count, element, setPressed, toggle } from "./dom";
import { chosenPly, maskPng, saveBlob, saveFrom } from "./files";
import { servedAddress, type SceneDescription, type SceneObject } from "./scene_data";
import type { Selection } from "./selection";
import type { View3d } from "./view3d";

export function objectName(object: SceneObject): string {
  return object.words[0] ?? `object ${object.id}`;
}

export class ObjectPanel {
  readonly root: HTMLElement;
  private readonly details = element("div", { class: "v-details" });
  private readonly list = element("ul", { class: "v-list", "aria-label": "Objects" });
  private readonly rows = new Map<number, HTMLButtonElement>();
  private readonly byId = new Map<number, SceneObject>();

  constructor(
    private readonly scene: SceneDescription,
    private readonly selection: Selection,
    private readonly view: View3d,
    /** Whether exact objects come from a server. */
    private readonly served: boolean,
    private readonly say: (text: string) => void,
  ) {
    const filter = element("input", {
      type: "search",
      class: "v-filter",
      placeholder: "Filter the list",
      "aria-label": "Filter the list of objects",
      input: () => this.fill(filter.value),
    });
    for (const object of scene.objects) {
      this.byId.set(object.id, object);
      const [r, g, b] = object.color;
      const row = element(
        "button",
        { type: "button", click: () => selection.choose(object.id) },
        element("span", {
          class: "swatch",
          style: `background:rgb(${r},${g},${b})`,
          "aria-hidden": "true",
        }),
        element("span", { class: "v-name" }, objectName(object)),
        object.background ? element("span", { class: "quiet" }, "background") : null,
      );
      row.dataset.object = String(object.id);
      row.addEventListener("dblclick", () => view.approach(object));
      this.rows.set(object.id, row);
    }
    this.root = element(
      "aside",
      { class: "v-panel", "aria-label": "Objects" },
      this.details,
      filter,
      this.list,
    );
    this.fill("");
    selection.onChange(() => this.update());
    this.update();
  }

  private fill(filter: string): void {
    const words = filter.toLowerCase();
    this.list.replaceChildren();
    // What stands in the scene first, then walls and floors.
    const objects = [...this.scene.objects].sort(
      (a, b) => Number(a.background) - Number(b.background),
    );
    for (const object of objects) {
      const text = [objectName(object), ...object.words, object.id].join(" ");
      if (!text.toLowerCase().includes(words)) continue;
      this.list.append(element("li", {}, this.rows.get(object.id)));
    }
    if (!this.list.childElementCount) {
      this.list.append(
        element(
          "li",
          { class: "quiet" },
          this.scene.objects.length
            ? "No object has these words."
            : "No object was found.",
        ),
      );
    }
  }

  private update(): void {
    const { selection } = this;
    for (const [id, row] of this.rows) {
      setPressed(row, selection.choice?.id === id && !selection.choice.region);
      row.classList.toggle("v-hidden", selection.hidden.has(id));
    }
    const choice = selection.choice;
    const object = choice && this.byId.get(choice.id);
    this.details.replaceChildren();
    delete this.details.dataset.object;
    if (!choice || !object) {
      this.details.append(
        element(
          "p",
          { class: "quiet" },
          this.scene.objects.length
            ? "Click an object in the scene or in the list."
            : "Stage bootstrap has not been run or found no objects.",
        ),
      );
      if (selection.hidden.size > 0) {
        this.details.append(
          button("Show all", "Show what was hidden", () => selection.showAll()),
        );
      }
      return;
    }
    this.details.dataset.object = String(object.id);
    this.details.append(...this.describe(object));
    const levels =
      choice.steps === 0
        ? ""
        : choice.steps > 0
          ? `${choice.steps} wider than `
          : `a part of, ${-choice.steps} narrower than `;
    this.say(levels + objectName(object) + " is chosen");
  }

  private describe(object: SceneObject): Node[] {
    const { selection, view } = this;
    const choice = selection.choice!;
    const size = object.obb.size.map((side) => (side * this.scene.unit).toPrecision(3));
    const rows: [string, string][] = [
      ["Words", object.words.slice(0, 3).join(", ") || "none"],
      ["Score", object.score.toFixed(2)],
      ["Gaussians", count(object.num_gaussians)],
      ["Box", `${size.join(" × ")} world units`],
    ];
    const narrower = button("Narrower", "The part that was clicked (,)", () =>
      selection.step(-1),
    );
    const wider = button("Wider", "What it is a part of (.)", () => selection.step(1));
    narrower.disabled = !selection.canStep(-1);
    wider.disabled = !selection.canStep(1);
    const only = toggle("Only this", "Hide all else (O)", (on) =>
      selection.setIsolated(on),
    );
    setPressed(only, selection.isolated);
    const hide = button("Hide", "Hide this object (H)", () =>
      selection.setHidden(object.id, true),
    );
    hide.disabled = choice.region !== null;
    const title = choice.region
      ? choice.steps > 0
        ? `What ${objectName(object)} is a part of`
        : `A part of ${objectName(object)}`
      : objectName(object);
    return [
      element("h3", {}, title),
      element(
        "dl",
        {},
        ...rows.flatMap(([name, value]) => [
          element("dt", {}, name),
          element("dd", {}, value),
        ]),
      ),
      element(
        "div",
        { class: "v-buttons" },
        wider,
        narrower,
        button("Go there", "Frame the object (G)", () => view.approach(object)),
        only,
        hide,
        button("Clear", "Choose nothing (Escape)", () => selection.clear()),
      ),
      element(
        "div",
        { class: "v-buttons" },
        button(
          "Save mask",
          "Its pixels in this view, as PNG (M)",
          () => void this.saveMask(),
        ),
        button("Save .ply", "Its Gaussians, for other programs (P)", () =>
          this.savePly(),
        ),
      ),
    ];
  }

  private fileName(suffix: string): string {
    const choice = this.selection.choice!;
    const object = this.byId.get(choice.id)!;
    const level =
      choice.steps === 0 ? "" : `_${choice.steps > 0 ? "+" : ""}${choice.steps}`;
    return `${objectName(object)}_${object.id}${level}${suffix}`;
  }

  /** Whether all Gaussians are here; says so if not, because files need them. */
  private isWhole(): boolean {
    const whole = this.view.cloud.gaussians.count === this.scene.num_gaussians;
    if (!whole) this.say("Nothing is saved before the whole scene is here");
    return whole;
  }

  async saveMask(): Promise<void> {
    if (!this.selection.choice || !this.isWhole()) return;
    const { mask, width, height } = this.view.mask();
    const view = this.view.photo ? `_${this.view.photo.name}` : "";
    // Before the wait: another object, or none, may be chosen after it.
    const name = this.fileName(`${view}.png`);
    saveBlob(await maskPng(mask, width, height), name);
  }

  savePly(): void {
    const choice = this.selection.choice;
    if (!choice) return;
    if (this.served && !choice.region) {
      const address = servedAddress(this.scene, `/api/instances/${choice.id}.ply`);
      saveFrom(address, this.fileName(".ply"));
      return;
    }
    if (!this.isWhole()) return;
    saveBlob(chosenPly(this.scene, this.view.cloud), this.fileName(".ply"));
  }
}
