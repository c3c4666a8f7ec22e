// SPDX-License-Identifier: BSD-3-Clause
// Small helpers to build the page. Texts are always text, never markup: names
// of photos and words may hold anything.

type Child = Node | string | null | undefined;

export function element<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Record<string, string | boolean | ((event: Event) => void)> = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") node.addEventListener(name, value);
    else if (typeof value === "boolean") node.toggleAttribute(name, value);
    else node.setAttribute(name, value);
  }
  node.append(...children.filter((child): child is Node | string => child != null));
  return node;
}

export function button(
  label: string,
  title: string,
  action: () => void,
): HTMLButtonElement {
  return element("button", { type: "button", title, click: action }, label);
}

/** A button that is on or off. */
export function toggle(
  label: string,
  title: string,
  action: (on: boolean) => void,
): HTMLButtonElement {
  const node = button(label, title, () => {
    setPressed(node, node.getAttribute("aria-pressed") !== "true");
    action(node.getAttribute("aria-pressed") === "true");
  });
  setPressed(node, false);
  return node;
}

export function setPressed(node: HTMLElement, on: boolean): void {
  node.setAttribute("aria-pressed", String(on));
}

export function count(number: number): string {
  return number.toLocaleString("en");
}
