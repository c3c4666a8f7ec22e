// SPDX-License-Identifier: BSD-3-Clause
// Jumping to the photos' cameras, and fading between photo and render.

import { photoRectangle } from "./cameras";
import { button, element } from "./dom";
import type { SceneDescription } from "./scene_data";
import type { View3d } from "./view3d";

export class PhotoBar {
  readonly root: HTMLElement;
  private readonly picture = element("img", { class: "v-photo", alt: "" });
  private readonly choose: HTMLSelectElement;
  private readonly fade: HTMLInputElement;
  private readonly holder: HTMLElement;
  /** The address of the picture that has been loaded. */
  private loaded = "";

  constructor(
    private readonly scene: SceneDescription,
    private readonly view: View3d,
    holder: HTMLElement,
  ) {
    this.holder = holder;
    this.picture.hidden = true;
    this.picture.addEventListener("load", () => {
      // Not if another photo was asked for since.
      if (!this.picture.complete) return;
      this.loaded = this.picture.getAttribute("src") ?? "";
      this.update();
    });
    holder.append(this.picture);
    this.choose = element("select", {
      "aria-label": "Photo",
      change: () => this.go(Number(this.choose.value)),
    });
    this.choose.append(new Option("free view", "-1"));
    scene.photos.forEach((photo, i) => {
      const kept = photo.holdout ? " (kept from training)" : "";
      this.choose.append(new Option(photo.name + kept, String(i)));
    });
    this.fade = element("input", {
      type: "range",
      min: "0",
      max: "100",
      value: "0",
      "aria-label": "Fade from the render to the photo",
      input: () => this.update(),
    });
    this.root = element(
      "div",
      { class: "v-photobar", role: "group", "aria-label": "Photos" },
      button("◀", "Photo before ([)", () => this.next(-1)),
      this.choose,
      button("▶", "Next photo (])", () => this.next(1)),
      element("label", {}, "render ", this.fade, " photo"),
    );
    view.onPhoto(() => this.update());
    new ResizeObserver(() => this.update()).observe(holder);
    this.update();
  }

  /** Prefers photos that the page can show, else goes through all cameras. */
  next(direction: 1 | -1): void {
    const { photos } = this.scene;
    if (photos.length === 0) return;
    const withPicture = photos.flatMap((photo, i) => (photo.image ? [i] : []));
    const order = withPicture.length > 0 ? withPicture : photos.map((_, i) => i);
    const now = this.view.photo ? photos.indexOf(this.view.photo) : -1;
    const at =
      direction > 0
        ? (order.find((i) => i > now) ?? order[0])
        : ([...order].reverse().find((i) => i < now) ?? order[order.length - 1]);
    this.go(at);
  }

  go(index: number): void {
    if (index >= 0) this.view.goTo(this.scene.photos[index]);
    else this.view.home();
  }

  private update(): void {
    const photo = this.view.photo;
    this.choose.value = String(photo ? this.scene.photos.indexOf(photo) : -1);
    this.fade.disabled = !photo?.image;
    const strength = Number(this.fade.value) / 100;
    if (photo?.image && this.picture.getAttribute("src") !== photo.image) {
      this.loaded = "";
      this.picture.src = photo.image;
    }
    // Until its own picture is there, the element shows that of the photo before.
    this.picture.hidden =
      !photo?.image || strength === 0 || this.loaded !== photo.image;
    if (!photo?.image) return;
    const rectangle = photoRectangle(
      photo,
      this.holder.clientWidth,
      this.holder.clientHeight,
    );
    Object.assign(this.picture.style, {
      left: `${rectangle.x}px`,
      top: `${rectangle.y}px`,
      width: `${rectangle.width}px`,
      height: `${rectangle.height}px`,
      opacity: String(strength),
    });
  }
}
