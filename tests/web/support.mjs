// SPDX-License-Identifier: BSD-3-Clause
// What the tests of the page share: a scene with known truth, and a browser.
// PAGE_TEST_BUILD is the build folder.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import {
  existsSync,
  mkdirSync,
  readFileSync,
  readdirSync,
  renameSync,
  rmSync,
  statSync,
  writeFileSync,
} from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { gzipSync } from "node:zlib";

export const build = process.env.PAGE_TEST_BUILD;
// The page's packages lie where it was bundled.
const require = createRequire(join(build, "web", "package.json"));
const { chromium } = require("playwright-core");
const { PNG } = require("pngjs");
export const axe = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
export const program = join(build, "bin", "freegs_pipeline");

const scratch = join(build, "tests", "web");

export function runProgram(...args) {
  return execFileSync(program, args, {
    encoding: "utf8",
    stdio: ["ignore", "pipe", "pipe"],
  });
}

/** Whether a file was written before one of those that it is made by. */
function isOlder(file, makers) {
  const time = (path) => statSync(path).mtimeMs;
  return makers.some((maker) => time(maker) > time(file));
}

/**
 * A drawn table with objects, reconstructed with its true cameras. It is kept
 * from one run of the tests to the next. It is drawn anew when the program that
 * draws it is newer, and the run then does again what the new photos change.
 * The report is written anew when the program or its page is newer, of which
 * the stage takes no notice. The tests that share the scene run one after the
 * other (RESOURCE_LOCK in tests/CMakeLists.txt).
 */
export function makeScene() {
  mkdirSync(scratch, { recursive: true });
  const truth = join(scratch, "table");
  const workspace = join(scratch, "table_workspace");
  const maker = join(build, "bin", "freegs_make_scene");
  const cameras = join(truth, "gt", "cameras.json");
  if (!existsSync(cameras) || isOlder(cameras, [maker])) {
    // Under its name there is never half a scene.
    const partial = `${truth}.partial`;
    rmSync(partial, { recursive: true, force: true });
    execFileSync(
      maker,
      [
        "--out",
        partial,
        "--views",
        "24",
        "--test_views",
        "3",
        "--seed",
        "3",
      ].concat(["--width", "480", "--height", "360"]),
      { stdio: "ignore" },
    );
    rmSync(truth, { recursive: true, force: true });
    renameSync(partial, truth);
  }
  const web = join(build, "share", "freegs_pipeline", "web");
  const bundle = readdirSync(web).map((name) => join(web, name));
  const exported = join(workspace, "export");
  const record = join(exported, "stage.json");
  if (existsSync(record) && isOlder(record, [program, ...bundle])) {
    rmSync(exported, { recursive: true, force: true });
  }
  runProgram(
    "run",
    join(truth, "images"),
    workspace,
    "--sfm.import",
    join(truth, "gt", "transforms.json"),
    "--sfm.random_points",
    "10000",
    "--threads",
    "1",
    "--preset",
    "fast",
    // Half of the preset's: the objects are found all the same.
    "--reconstruct.iterations",
    "750",
    "--reconstruct.budget",
    "8000",
  );
  return {
    truth,
    workspace,
    report: join(workspace, "export", "report", "index.html"),
  };
}

/**
 * A page with nothing but white Gaussians on black, each of which is an object of
 * its own with the ids 1, 2, ...; its address. A Gaussian has `mean`, `scales`
 * (standard deviations along the axes of the scene) and `opacity`. Photos look
 * along z, stand at z = -5, and have the size and the focal length of `photo`;
 * `images` are their files.
 */
export function writeGaussians(
  name,
  gaussians,
  photo,
  images = [""],
  antialiased = false,
) {
  const web = pathToFileURL(
    join(build, "share", "freegs_pipeline", "web"),
  ).href;
  const fractionBits = 10;
  const bytes = [];
  const put = (value, count) => {
    for (let i = 0; i < count; ++i) bytes.push((value >> (8 * i)) & 255);
  };
  // The .spz format, version 2.
  put(0x5053474e, 4);
  put(2, 4);
  put(gaussians.length, 4);
  bytes.push(0, fractionBits, 0, 0);
  for (const { mean } of gaussians) {
    for (const x of mean) put(Math.round(x * 2 ** fractionBits), 3);
  }
  for (const { opacity } of gaussians) bytes.push(Math.round(255 * opacity));
  const white = Math.min(
    255,
    Math.round(255 * ((0.5 / 0.2820948) * 0.15 + 0.5)),
  );
  bytes.push(...Array(3 * gaussians.length).fill(white));
  for (const { scales } of gaussians) {
    for (const s of scales) bytes.push(Math.round(16 * (Math.log(s) + 10)));
  }
  // The identity, as the imaginary parts of a quaternion.
  bytes.push(...Array(3 * gaussians.length).fill(128));
  const labels = Uint16Array.from(
    gaussians.flatMap((_, i) => [i + 1, 65535 /* no part */]),
  );
  const box = { center: [0, 0, 0], size: [1, 1, 1] };
  const axes = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ];
  const description = {
    ...{ format: "freegs-viewer-scene", version: 1, title: name },
    ...{
      origin: [0, 0, 0],
      unit: 1,
      up: [0, -1, 0],
      focus: [0, 0, 0],
      radius: 5,
    },
    ...{ background: [0, 0, 0], antialiased, sh_degree: 0, levels: {} },
    num_gaussians: gaussians.length,
    photos: images.map((image, i) => ({
      ...{
        name: `photo ${i}`,
        holdout: false,
        image,
        fx: photo.focal,
        fy: photo.focal,
      },
      ...{ width: photo.width, height: photo.height },
      ...{ cx: photo.width / 2, cy: photo.height / 2 },
      ...{ rotation: [1, 0, 0, 0], translation: [0, 0, 5] },
    })),
    objects: gaussians.map((_, i) => ({
      ...{ id: i + 1, words: [`ball ${i + 1}`], score: 1, background: false },
      ...{
        num_gaussians: 1,
        color: [255, 0, 0],
        obb: { ...box, rotation: axes },
      },
    })),
    parts: [{ num_gaussians: gaussians.length }],
  };
  const parts = [
    {
      splats: gzipSync(Uint8Array.from(bytes)).toString("base64"),
      labels: Buffer.from(labels.buffer).toString("base64"),
    },
  ];
  const folder = join(scratch, "gaussians");
  mkdirSync(folder, { recursive: true });
  writeFileSync(
    join(folder, `${name}.js`),
    `globalThis.freegsScene = ${JSON.stringify({ description, parts })}`,
  );
  const page = join(folder, `${name}.html`);
  writeFileSync(
    page,
    `<!doctype html><meta name="viewport" content="width=device-width">
     <link rel="stylesheet" href="${web}/viewer.css">
     <div id="scene3d" data-scene="${name}.js"></div>
     <script src="${web}/viewer.js" defer></script>`,
  );
  return pathToFileURL(page).href;
}

/** Shows one object alone. */
export function isolate(page, id) {
  return page.evaluate((object) => {
    const { selection } = globalThis.freegsViewer;
    selection.choose(object);
    selection.setIsolated(true);
  }, id);
}

/**
 * Waits until the canvas has a grey value at a point (CSS pixels, to the right of
 * the middle), give or take a few. Fails if it does not get it.
 */
export async function expectGrey(page, right, expected, tolerance = 3) {
  const found = await page.evaluate(
    async ([x, wanted, within]) => {
      const { view } = globalThis.freegsViewer;
      const copy = document.createElement("canvas");
      const context = copy.getContext("2d", { willReadFrequently: true });
      let grey = -1;
      for (let i = 0; i < 100 && Math.abs(grey - wanted) > within; ++i) {
        if (i > 0) await new Promise((resolve) => setTimeout(resolve, 100));
        copy.width = view.canvas.width;
        copy.height = view.canvas.height;
        context.drawImage(view.canvas, 0, 0);
        const column = (copy.width / view.width) * (view.width / 2 + x);
        const row = copy.height >> 1;
        grey = context.getImageData(Math.floor(column), row, 1, 1).data[0];
      }
      return grey;
    },
    [right, expected, tolerance],
  );
  assert.ok(
    Math.abs(found - expected) <= tolerance,
    `${found} instead of ${expected} at ${right} beside the middle`,
  );
}

/** Grey values of a PNG, of 8 or 16 bits. */
export function readGrey(path) {
  const png = PNG.sync.read(readFileSync(path), { skipRescale: true });
  const values = new Uint16Array(png.width * png.height);
  for (let i = 0; i < values.length; ++i) values[i] = png.data[4 * i];
  return { width: png.width, height: png.height, values };
}

export async function openBrowser() {
  return chromium.launch({
    executablePath: process.env.PAGE_TEST_CHROMIUM,
    args: [
      "--no-sandbox", // Tests may run as root.
      "--use-angle=swiftshader",
      "--enable-unsafe-swiftshader",
      "--ignore-gpu-blocklist",
    ],
  });
}

/**
 * A page whose 3D view is there; fails when the page reports an error. The window
 * is small because each pixel takes its time without a graphics card.
 */
export async function openPage(
  browser,
  url,
  viewport = { width: 960, height: 680 },
  options = {},
) {
  const context = await browser.newContext({
    viewport,
    acceptDownloads: true,
    ...options,
  });
  const page = await context.newPage();
  page.errors = [];
  page.dialogs = 0; // Nothing opens one, unless markup in a name ran.
  page.on("dialog", (dialog) => (++page.dialogs, dialog.dismiss()));
  page.on("pageerror", (error) => page.errors.push(String(error)));
  page.on("console", (message) => {
    // The page asks again when the server is busy (status 429). The browser
    // reports each such answer all the same.
    if (message.type() === "error" && !message.text().includes("of 429"))
      page.errors.push(message.text());
  });
  page.setDefaultTimeout(90000);
  await page.goto(url);
  await page.waitForFunction(() => {
    const scene = document.querySelector("#scene3d");
    return scene?.dataset.loaded || scene?.dataset.failed;
  });
  const failed = await page.evaluate(
    () => document.querySelector("#scene3d").dataset.failed,
  );
  assert.equal(failed, undefined, `the 3D view: ${failed}`);
  assert.deepEqual(page.errors, []);
  return page;
}

/** Waits until the view has drawn everything there is and is at rest. */
export async function settle(page) {
  await page.evaluate(
    () =>
      new Promise((resolve) => {
        const { statistics } = globalThis.freegsViewer.view;
        let seen = -1;
        let calm = 0;
        const look = () => {
          const last = statistics.times.at(-1) ?? 0;
          calm = statistics.first !== null && last === seen ? calm + 1 : 0;
          seen = last;
          if (calm < 4) setTimeout(look, 200);
          else resolve();
        };
        look();
      }),
  );
}

/** Brings the page's camera to a camera of the truth; returns its rectangle. */
export function goToCamera(page, intrinsics, worldToCamera) {
  return page.evaluate(
    ([k, m]) => {
      const { view } = globalThis.freegsViewer;
      const { unit, origin } = globalThis.freegsScene.description;
      const r = m.map((row) => row.slice(0, 3));
      // The rotation as a quaternion w x y z (Shepperd 1978).
      const trace = r[0][0] + r[1][1] + r[2][2];
      const d = [trace, r[0][0], r[1][1], r[2][2]];
      const best = d.indexOf(Math.max(...d));
      const q = [0, 0, 0, 0];
      if (best === 0) {
        q[0] = 1 + trace;
        q[1] = r[2][1] - r[1][2];
        q[2] = r[0][2] - r[2][0];
        q[3] = r[1][0] - r[0][1];
      } else {
        const i = best - 1;
        const j = (i + 1) % 3;
        const l = (i + 2) % 3;
        q[best] = 1 + r[i][i] - r[j][j] - r[l][l];
        q[0] = r[l][j] - r[j][l];
        q[1 + j] = r[j][i] + r[i][j];
        q[1 + l] = r[l][i] + r[i][l];
      }
      const norm = Math.hypot(...q);
      const photo = {
        name: "truth",
        holdout: true,
        image: "",
        width: k.w,
        height: k.h,
        fx: k.fx,
        fy: k.fy,
        cx: k.cx,
        cy: k.cy,
        rotation: q.map((x) => x / norm),
        translation: r.map(
          (row, i) =>
            (m[i][3] +
              row[0] * origin[0] +
              row[1] * origin[1] +
              row[2] * origin[2]) /
            unit,
        ),
      };
      view.goTo(photo);
      const scale = Math.min(view.width / k.w, view.height / k.h);
      return {
        scale,
        x: (view.width - scale * k.w) / 2,
        y: (view.height - scale * k.h) / 2,
      };
    },
    [intrinsics, worldToCamera],
  );
}
