// SPDX-License-Identifier: BSD-3-Clause
// The 3D view of the page: canvas, tool bar, photos, objects, keys.

import { button, element, setPressed, toggle } from "./dom";
import { ObjectPanel } from "./object_panel";
import { PhotoBar } from "./photo_bar";
import { QueryBar } from "./query_bar";
import type { SceneSource } from "./scene_data";
import { Selection } from "./selection";
import { View3d } from "./view3d";

const KEYS: [string, string][] = [
  ["drag, arrow keys", "turn"],
  ["wheel, pinch, + and −", "nearer, farther"],
  ["W A S D Q E", "move"],
  ["click, Enter", "choose the object there, or in the middle"],
  [", and .", "narrower: its part; wider: what it is a part of"],
  ["O, H, Escape", "only this, hide, choose nothing"],
  ["G", "go to the object"],
  ["I, B, C", "colours of objects, boxes, cameras"],
  ["[ and ]", "photo before, next photo"],
  ["M, P", "save mask, save .ply"],
  ["F, R", "fly or turn, first view"],
];

/** What tests, and people at the console of the browser, reach the view by. */
export interface ViewerHandle {
  view: View3d;
  selection: Selection;
  loaded: Promise<void>;
}

declare global {
  var freegsViewer: ViewerHandle | undefined;
}

/** Throws where there is no WebGL 2. */
export function startViewer(
  holder: HTMLElement,
  source: SceneSource,
  served: boolean,
): ViewerHandle {
  const scene = source.description;
  const selection = new Selection(scene);
  const picture = element("div", { class: "v-canvas" });
  const progress = element("p", { class: "v-progress", role: "status" });
  const status = element("p", { class: "v-hide", role: "status" });
  const view = new View3d(picture, scene, selection);
  const panel = new ObjectPanel(scene, selection, view, served, (text) => {
    status.textContent = text;
  });
  const photos = new PhotoBar(scene, view, picture);

  const colored = toggle("Objects", "Colours of the objects (I)", (on) =>
    selection.setColored(on),
  );
  const boxes = toggle("Boxes", "Boxes of the objects (B)", (on) => view.showBoxes(on));
  const cameras = toggle("Cameras", "Cameras of the photos (C)", (on) =>
    view.showCameras(on),
  );
  const fly = toggle("Fly", "Look around instead of turning the scene (F)", (on) =>
    view.navigation.setFlying(on),
  );
  const help = element(
    "dialog",
    { class: "v-help", "aria-label": "Keys" },
    element("h3", {}, "Keys"),
    element(
      "dl",
      {},
      ...KEYS.flatMap(([keys, what]) => [
        element("dt", {}, keys),
        element("dd", {}, what),
      ]),
    ),
    button("Close", "Close (Escape)", () => help.close()),
  );
  const layout = element("div", { class: "v-layout" });
  const full = button("Full screen", "Full screen", () => {
    if (document.fullscreenElement) void document.exitFullscreen();
    else void layout.requestFullscreen();
  });
  const tools = element(
    "div",
    { class: "v-tools", role: "toolbar", "aria-label": "View" },
    colored,
    boxes,
    cameras,
    fly,
    button("First view", "Back to the first view (R)", () => view.home()),
    full,
    button("Keys", "Keys (?)", () => help.showModal()),
  );
  const queries = served ? new QueryBar(scene, selection) : null;
  layout.append(
    element(
      "div",
      { class: "v-main" },
      tools,
      picture,
      photos.root,
      queries?.root ?? null,
      progress,
      status,
    ),
    panel.root,
    help,
  );
  holder.replaceChildren(layout);
  view.home();

  const shortcuts: Record<string, () => void> = {
    i: () => colored.click(),
    b: () => boxes.click(),
    c: () => cameras.click(),
    f: () => fly.click(),
    r: () => view.home(),
    "?": () => help.showModal(),
    "[": () => photos.next(-1),
    "]": () => photos.next(1),
    ",": () => void selection.step(-1),
    ".": () => void selection.step(1),
    o: () => selection.setIsolated(!selection.isolated),
    h: () => {
      // As the button: a region is no object.
      const { choice } = selection;
      if (choice && !choice.region) selection.setHidden(choice.id, true);
    },
    m: () => void panel.saveMask(),
    p: () => panel.savePly(),
    g: () => {
      const object = scene.objects.find((o) => o.id === selection.choice?.id);
      if (object) view.approach(object);
    },
    Escape: () => selection.clear(),
  };
  layout.addEventListener("keydown", (event) => {
    const typing =
      (event.target instanceof HTMLInputElement && event.target.type !== "range") ||
      event.target instanceof HTMLSelectElement;
    if (typing || event.ctrlKey || event.metaKey || event.altKey || help.open) return;
    const action = shortcuts[event.key];
    if (!action) return;
    action();
    event.preventDefault();
  });
  setPressed(fly, false);

  choosePointedAt(view, selection);
  const started = performance.now();
  const loaded = view.cloud
    .load(source, () => {
      const { count } = view.cloud.gaussians;
      const all = scene.num_gaussians;
      progress.textContent =
        count < all ? `${Math.floor((100 * count) / all)} % of the scene is here` : "";
      view.redraw();
    })
    .catch((error: unknown) => {
      progress.textContent = `The scene cannot be shown: ${String(error)}`;
      throw error;
    });
  loaded.then(
    () => (holder.dataset.loaded = String(Math.round(performance.now() - started))),
    () => {},
  );
  globalThis.freegsViewer = { view, selection, loaded };
  return globalThis.freegsViewer;
}

/** A click chooses, a drag does not. */
function choosePointedAt(view: View3d, selection: Selection): void {
  const choose = (x: number, y: number) => {
    const found = view.pick(x, y);
    if (found) selection.choose(found.id, found.part);
    else selection.clear();
  };
  let start: PointerEvent | null = null;
  view.canvas.addEventListener("pointerdown", (event) => {
    start = event.isPrimary && event.button === 0 ? event : null;
  });
  view.canvas.addEventListener("pointerup", (event) => {
    if (!start || event.pointerId !== start.pointerId) return;
    const moved = Math.hypot(
      event.clientX - start.clientX,
      event.clientY - start.clientY,
    );
    start = null;
    if (moved > 4) return;
    const box = view.canvas.getBoundingClientRect();
    choose(event.clientX - box.left, event.clientY - box.top);
  });
  view.canvas.addEventListener("keydown", (event) => {
    if (event.key !== "Enter") return;
    choose(view.width / 2, view.height / 2);
    event.preventDefault();
  });
}
