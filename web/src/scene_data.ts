// SPDX-License-Identifier: BSD-3-Clause
// The scene as the program describes it (stages/viewer/viewer_scene.h), and
// where the page gets it from: the script scene.js beside it, or the server of
// `freegs_pipeline view`.

export type Vec3 = [number, number, number];
export type Quaternion = [number, number, number, number]; // w x y z

/** A posed pinhole camera: x right, y down, z forward; pixels of the photo. */
export interface Photo {
  name: string;
  holdout: boolean;
  width: number;
  height: number;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
  /** Camera from scene. */
  rotation: Quaternion;
  translation: Vec3;
  /** Path relative to the page; empty when the page has no such picture. */
  image: string;
}

export interface SceneObject {
  id: number;
  words: string[];
  score: number;
  background: boolean;
  num_gaussians: number;
  color: Vec3; // 0 to 255
  obb: { center: Vec3; size: Vec3; rotation: [Vec3, Vec3, Vec3] };
}

/** Regions are intervals [begin, end) of parts. */
export type Interval = [number, number];

/** What an object is a part of, and its parts. */
export interface ObjectLevels {
  /** From the next larger region to the whole scene. */
  wider: Interval[];
  /** All smaller regions. Two of them are one in the other, or share no part. */
  narrower: Interval[];
}

export interface SceneDescription {
  format: "freegs-viewer-scene";
  version: 1;
  title: string;
  /** World = unit * scene + origin. */
  origin: Vec3;
  unit: number;
  up: Vec3;
  focus: Vec3;
  radius: number;
  background: Vec3; // 0 to 1
  antialiased: boolean;
  num_gaussians: number;
  photos: Photo[];
  objects: SceneObject[];
  /** By object id; empty when bootstrap left no hierarchy. */
  levels: Record<string, ObjectLevels>;
  parts: { num_gaussians: number }[];
  /** Which of its scenes the server gave; none where the page has its own. */
  stamp?: string;
}

/** The address of something that the server has of this scene. */
export function servedAddress(scene: SceneDescription, path: string): string {
  return scene.stamp ? `${path}?scene=${encodeURIComponent(scene.stamp)}` : path;
}

/** Some of the Gaussians. */
export interface ScenePart {
  splats: Uint8Array; // .spz, in the frame of the scene
  /** Per Gaussian the object's id (0: none) and its part (65535: none). */
  labels: Uint16Array;
}

export const NO_PART = 65535;

export interface SceneSource {
  description: SceneDescription;
  part(index: number): Promise<ScenePart>;
}

interface EmbeddedScene {
  description: SceneDescription;
  parts: { splats: string; labels: string }[];
}

declare global {
  var freegsScene: EmbeddedScene | undefined;
}

function decodeBase64(text: string): Uint8Array {
  const characters = atob(text);
  const bytes = new Uint8Array(characters.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = characters.charCodeAt(i);
  return bytes;
}

/** Little-endian, as the file is; also where the machine is not. */
function decodeLabels(bytes: Uint8Array): Uint16Array {
  const labels = new Uint16Array(bytes.length >> 1);
  for (let i = 0; i < labels.length; ++i) {
    labels[i] = bytes[2 * i] | (bytes[2 * i + 1] << 8);
  }
  return labels;
}

/** Runs a script that may be of several megabytes. */
function loadScript(url: string): Promise<void> {
  return new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = url;
    script.onload = () => resolve();
    script.onerror = () => reject(new Error(`${url} cannot be read`));
    document.head.append(script);
  });
}

export async function openEmbeddedScene(url: string): Promise<SceneSource> {
  if (!globalThis.freegsScene) await loadScript(url);
  const scene = globalThis.freegsScene;
  if (!scene || scene.description?.format !== "freegs-viewer-scene") {
    throw new Error(`${url} holds no scene`);
  }
  return {
    description: scene.description,
    part: async (index) => {
      const part = scene.parts[index];
      const result = {
        splats: decodeBase64(part.splats),
        labels: decodeLabels(decodeBase64(part.labels)),
      };
      part.splats = part.labels = ""; // They are not needed twice.
      return result;
    },
  };
}

/** Asks again each second while the server makes the scene ready for others. */
async function fetchWhenReady(url: string, options?: RequestInit): Promise<Response> {
  for (;;) {
    const answer = await fetch(url, options);
    if (answer.status !== 429) return answer;
    await new Promise((resolve) => setTimeout(resolve, 1000));
  }
}

async function fetchBytes(url: string): Promise<Uint8Array> {
  const answer = await fetchWhenReady(url);
  if (answer.status === 409) {
    throw new Error("the scene has changed meanwhile; load the page again");
  }
  if (!answer.ok) throw new Error(`${url}: ${answer.status}`);
  return new Uint8Array(await answer.arrayBuffer());
}

/** Whether the server has a scene for the page. */
export async function hasServedScene(): Promise<boolean> {
  const answer = await fetchWhenReady("/api/scene", { method: "HEAD" }).catch(
    () => null,
  );
  return answer?.ok === true;
}

/** Null where the server's program was built without the 3D view. */
export async function openServedScene(): Promise<SceneSource | null> {
  const answer = await fetchWhenReady("/api/scene");
  if (answer.status === 503) return null;
  if (!answer.ok) {
    const body = await answer.json().catch(() => ({}));
    throw new Error(body.error ?? `the scene cannot be read: ${answer.status}`);
  }
  const description = (await answer.json()) as SceneDescription;
  description.stamp = answer.headers.get("Scene-Stamp") ?? undefined;
  for (const photo of description.photos) {
    photo.image =
      "/api/photos/" + photo.name.split("/").map(encodeURIComponent).join("/");
  }
  return {
    description,
    part: async (index) => {
      const [splats, labels] = await Promise.all([
        fetchBytes(servedAddress(description, `/api/parts/${index}/splats.spz`)),
        fetchBytes(servedAddress(description, `/api/parts/${index}/labels.bin`)),
      ]);
      return { splats, labels: decodeLabels(labels) };
    },
  };
}
