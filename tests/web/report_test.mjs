// SPDX-License-Identifier: BSD-3-Clause
// The report as a file, in a browser that draws without a graphics card.

import assert from "node:assert/strict";
import {
  cpSync,
  mkdirSync,
  readFileSync,
  rmSync,
  writeFileSync,
} from "node:fs";
import { dirname, join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";

import {
  axe,
  build,
  expectGrey,
  goToCamera,
  isolate,
  makeScene,
  openBrowser,
  openPage,
  readGrey,
  runProgram,
  settle,
  writeGaussians,
} from "./support.mjs";

let scene;
let browser;
let shared; // The report, opened once for several tests.
let cameras;
let instances; // What the program draws in the test views: ids.
let truth; // The true ids there.

before(async () => {
  scene = makeScene();
  cameras = JSON.parse(readFileSync(join(scene.truth, "gt", "cameras.json")));
  const out = join(dirname(scene.workspace), "instances");
  runProgram(
    "render",
    scene.workspace,
    "--out",
    out,
    "--cameras",
    join(scene.truth, "gt", "cameras.json"),
    "--what",
    "instances",
  );
  instances = new Map();
  truth = new Map();
  for (const name of Object.keys(cameras.test)) {
    instances.set(name, readGrey(join(out, name)));
    truth.set(name, readGrey(join(scene.truth, "gt", "instance", name)));
  }
  browser = await openBrowser();
});

after(() => browser?.close());

const open = (viewport, options) =>
  openPage(browser, pathToFileURL(scene.report).href, viewport, options);
/**
 * The report as other tests have left it, because opening it takes seconds. It is
 * for tests that do not ask how it opens, and that hide nothing for good.
 */
const openShared = async () => {
  shared ??= await open();
  return shared;
};
const chosen = (page) =>
  page.evaluate(() => globalThis.freegsViewer.selection.choice?.id ?? 0);

/** The id of the instance that overlaps an object best, and by how much. */
function bestInstance(object) {
  const overlap = new Map();
  const size = new Map();
  let pixels = 0;
  for (const [name, ids] of instances) {
    const mask = truth.get(name).values;
    ids.values.forEach((id, i) => {
      if (id > 0) size.set(id, (size.get(id) ?? 0) + 1);
      if (mask[i] !== object) return;
      ++pixels;
      if (id > 0) overlap.set(id, (overlap.get(id) ?? 0) + 1);
    });
  }
  let best = { id: 0, iou: 0 };
  for (const [id, both] of overlap) {
    const iou = both / (pixels + size.get(id) - both);
    if (iou > best.iou) best = { id, iou };
  }
  return best;
}

/** The pixel of an object in a view that is farthest from where it ends. */
function innermost({ width, height, values }, object) {
  let best = null;
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      if (values[y * width + x] !== object) continue;
      let reach = 0;
      const inside = (r) =>
        [
          [r, 0],
          [-r, 0],
          [0, r],
          [0, -r],
          [r, r],
          [-r, -r],
          [r, -r],
          [-r, r],
        ].every(
          ([dx, dy]) =>
            x + dx >= 0 &&
            y + dy >= 0 &&
            x + dx < width &&
            y + dy < height &&
            values[(y + dy) * width + x + dx] === object,
        );
      while (inside(reach + 1)) ++reach;
      if (!best || reach > best.reach) best = { x, y, reach };
    }
  }
  return best;
}

test("clicks on five objects in three views find what is there", async () => {
  const page = await openShared();
  await page.locator(".v-canvas").scrollIntoViewIfNeeded();
  const canvas = await page.locator(".v-canvas canvas").boundingBox();
  let clicks = 0;
  for (const [name, mask] of truth) {
    const rectangle = await goToCamera(
      page,
      cameras.intrinsics,
      cameras.test[name],
    );
    const objects = [...new Set(mask.values)].filter((id) => id > 0);
    const places = objects
      .map((object) => ({
        object,
        ...innermost(mask, object),
        ...bestInstance(object),
      }))
      .filter(({ reach, iou }) => reach >= 4 && iou > 0.5)
      .sort((a, b) => b.reach - a.reach)
      .slice(0, 5);
    assert.equal(places.length, 5, name);
    for (const { x, y, id, object } of places) {
      await page.mouse.click(
        canvas.x + rectangle.x + rectangle.scale * (x + 0.5),
        canvas.y + rectangle.y + rectangle.scale * (y + 0.5),
      );
      assert.equal(await chosen(page), id, `object ${object} in ${name}`);
      assert.equal(
        await page.locator(".v-details").getAttribute("data-object"),
        String(id),
      );
      ++clicks;
    }
  }
  assert.equal(clicks, 15);
  assert.ok(canvas.width > 300);
  // Haze that hides less than half of what is behind it is no object.
  const haze = await page.evaluate(() => {
    const { view } = globalThis.freegsViewer;
    const opacities = view.cloud.gaussians.opacities;
    const before = opacities.slice();
    opacities.fill(0.005);
    const found = view.pick(view.width / 2, view.height / 2);
    opacities.set(before);
    return found;
  });
  assert.equal(haze, null);
  assert.deepEqual(page.errors, []);
});

test("objects alone look as the program draws them", async () => {
  const page = await openShared();
  const name = Object.keys(cameras.test)[0];
  const ids = instances.get(name);
  const objects = [...new Set(truth.get(name).values)]
    .filter((id) => id > 0)
    .map((id) => ({ id, reach: innermost(truth.get(name), id).reach }))
    .sort((a, b) => b.reach - a.reach)
    .slice(0, 3)
    .map(({ id }) => bestInstance(id).id);
  const rectangle = await goToCamera(
    page,
    cameras.intrinsics,
    cameras.test[name],
  );
  for (const id of objects) {
    const alone = join(dirname(scene.workspace), "alone");
    runProgram(
      "render",
      scene.workspace,
      "--out",
      alone,
      "--cameras",
      join(scene.truth, "gt", "cameras.json"),
      "--what",
      "instances",
      "--only",
      String(id),
    );
    const expected = readGrey(join(alone, name)).values;
    await page.evaluate((chosenId) => {
      const { selection } = globalThis.freegsViewer;
      selection.choose(chosenId);
      selection.setIsolated(true);
    }, id);
    await settle(page);
    // The page's mask, and whether the canvas is not black, at the pixels of
    // the program's picture: a letter for each pixel, which take much less time
    // to come here than numbers.
    const { mask, width, height, drawn } = await page.evaluate((place) => {
      const { view } = globalThis.freegsViewer;
      const result = view.mask();
      const canvas = document.createElement("canvas");
      canvas.width = view.width;
      canvas.height = view.height;
      const context = canvas.getContext("2d");
      context.drawImage(view.canvas, 0, 0, view.width, view.height);
      const { data } = context.getImageData(0, 0, view.width, view.height);
      const lit = Array.from(result.mask, (_, i) => {
        const column = (i % result.width) + 0.5;
        const row = Math.floor(i / result.width) + 0.5;
        const x = Math.floor(place.x + place.scale * column);
        const y = Math.floor(place.y + place.scale * row);
        const at = 4 * (y * view.width + x);
        return data[at] + data[at + 1] + data[at + 2] > 15 ? 1 : 0;
      });
      return { ...result, mask: result.mask.join(""), drawn: lit.join("") };
    }, rectangle);
    assert.deepEqual([width, height], [ids.width, ids.height]);
    let program = 0;
    let both = 0;
    let either = 0;
    let lit = 0;
    let canvas = 0;
    assert.equal(mask.length, expected.length);
    expected.forEach((value, i) => {
      const inside = mask[i] !== "0";
      const seen = drawn[i] === "1";
      program += value === id;
      both += inside && value === id;
      either += inside || value === id;
      lit += inside && seen;
      canvas += seen;
    });
    assert.ok(both / either > 0.97, `instance ${id}: iou ${both / either}`);
    assert.ok(lit / program > 0.95, `instance ${id}: ${lit / program} lit`);
    // The canvas also shows the fringe that is covered by less than half, which is
    // much of a small thing, but no other object.
    assert.ok(lit / canvas > 0.25, `instance ${id}: ${lit / canvas} of it`);
  }
  await page.evaluate(() => globalThis.freegsViewer.selection.clear());
});

// The photo of Gaussians that are drawn with known places, and a viewport that
// shows it pixel by pixel.
const photo = { width: 980, height: 576, focal: 576 };
const viewport = { width: 1280, height: 900 };

test("Gaussians that are large, far, near, or centred outside of the view", async () => {
  const page = await openPage(
    browser,
    writeGaussians(
      "large",
      [
        { mean: [0, 0, 0], scales: [4, 4, 0.04], opacity: 0.9 },
        { mean: [9, 0, 0], scales: [6, 6, 0.06], opacity: 0.9 },
        // Along the line of sight. The projection counts as linear up to 0.15 of
        // the view's width beside it.
        { mean: [10, 0, 0], scales: [0.5, 0.5, 2], opacity: 0.9 },
        { mean: [0, 0, 7000], scales: [400, 400, 400], opacity: 0.9 },
        // Before and behind the program's near plane, which is at 0.2.
        { mean: [0, 0, -4.78], scales: [0.01, 0.01, 0.01], opacity: 0.9 },
        { mean: [0, 0, -4.82], scales: [0.01, 0.01, 0.01], opacity: 0.9 },
      ],
      photo,
    ),
    viewport,
  );
  const { gaussians, focal, width } = await page.evaluate(() => {
    const { view } = globalThis.freegsViewer;
    view.goTo(view.scene.photos[0]);
    const { means, scales } = view.cloud.gaussians;
    return {
      // The scales are those that the format can hold.
      gaussians: [0, 1, 2, 3, 4, 5].map((i) => ({
        x: means[3 * i],
        depth: means[3 * i + 2] + 5,
        across: scales[3 * i],
        along: scales[3 * i + 2],
      })),
      focal: view.pinhole(view.width, view.height).fx,
      width: view.width,
    };
  });
  for (const [i, { x, depth, across, along }] of gaussians.entries()) {
    const slope = Math.min(x / depth, (0.65 * width) / focal);
    const deviation = (focal / depth) * Math.hypot(across, slope * along);
    await isolate(page, i + 1);
    for (const dx of [0.49 * width, 0.25 * width, 0.5]) {
      const away = ((x * focal) / depth - dx) / deviation;
      // Spark ends at a distance of the square root of 8.
      const shown =
        depth > 0.2 && away ** 2 < 8 ? 0.9 * Math.exp(-0.5 * away ** 2) : 0;
      await expectGrey(page, dx, 255 * shown);
    }
  }
  assert.deepEqual(page.errors, []);
  await page.context().close();
});

test("Gaussians whose images are thousands of times as long as wide", async () => {
  for (const antialiased of [false, true]) {
    const page = await openPage(
      browser,
      writeGaussians(
        `long_${antialiased}`,
        // Along the line of sight. The second one's image is nearly level.
        [
          [0.153, 0.13, -4.66],
          [0.153, 0, -4.66],
        ].map((mean) => ({
          mean,
          scales: [0.0005, 0.0005, 8],
          opacity: 0.9,
        })),
        photo,
        [""],
        antialiased,
      ),
      viewport,
    );
    const { gaussians, focal } = await page.evaluate(() => {
      const { view } = globalThis.freegsViewer;
      view.goTo(view.scene.photos[0]);
      const { means, scales, rotations } = view.cloud.gaussians;
      return {
        gaussians: [0, 1].map((i) => ({
          mean: [...means.slice(3 * i, 3 * i + 3)],
          across: scales[3 * i],
          rotation: [...rotations.slice(4 * i, 4 * i + 4)],
        })),
        focal: view.pinhole(view.width, view.height).fx,
      };
    });
    for (const [i, { mean, across, rotation }] of gaussians.entries()) {
      await isolate(page, i + 1);
      const depth = mean[2] + 5;
      const [u, v] = [mean[0] / depth, mean[1] / depth];
      // The format has no exact identity, so the long axis is turned a little. The
      // image of this axis, and its normal:
      const [x, y, z, w] = rotation;
      const axis = [2 * (x * z + w * y), 2 * (y * z - w * x)];
      const forward = 1 - 2 * (x * x + y * y);
      const line = [axis[0] - u * forward, axis[1] - v * forward];
      const normal = [-line[1], line[0]].map((n) => n / Math.hypot(...line));
      const sharp =
        ((focal / depth) * across) ** 2 *
        (1 + (normal[0] * u + normal[1] * v) ** 2);
      const variance = sharp + 0.3;
      const most = 0.9 * Math.sqrt(antialiased ? sharp / variance : 1);
      // The row of pixels that is read has its middle half a pixel below that of
      // the picture.
      const crossing = focal * u + ((0.5 - focal * v) * line[0]) / line[1];
      for (const beside of [0, 100, -200]) {
        const dx = Math.floor(crossing) + 0.5 + beside;
        const away =
          (normal[0] * (dx - focal * u) + normal[1] * (0.5 - focal * v)) ** 2 /
          variance;
        const shown = away < 8 ? most * Math.exp(-0.5 * away) : 0;
        // Spark's rounded rotations put the line up to 0.15 pixels aside.
        await expectGrey(page, dx, 255 * shown, shown > 0 ? 15 : 3);
      }
    }
    assert.deepEqual(page.errors, []);
    await page.context().close();
  }
});

test("the view comes back after the graphics card was lost", async () => {
  const page = await openPage(
    browser,
    writeGaussians(
      "lost",
      [{ mean: [0, 0, 0], scales: [0.5, 0.5, 0.5], opacity: 0.9 }],
      photo,
    ),
  );
  await expectGrey(page, 0.5, 229);
  await page.evaluate(async () => {
    const { canvas } = globalThis.freegsViewer.view;
    const lost = canvas.getContext("webgl2").getExtension("WEBGL_lose_context");
    const hear = (name) =>
      new Promise((resolve) =>
        canvas.addEventListener(name, () => setTimeout(resolve), {
          once: true,
        }),
      );
    const gone = hear("webglcontextlost");
    lost.loseContext();
    await gone;
    const back = hear("webglcontextrestored");
    lost.restoreContext();
    await back;
  });
  await expectGrey(page, 0.5, 229);
  await page.context().close();
});

test("levels, hiding, saving a mask and a .ply", async () => {
  const page = await open();
  const id = await page.evaluate(() => {
    const { selection } = globalThis.freegsViewer;
    const { objects } = globalThis.freegsScene.description;
    selection.choose(objects.find((object) => !object.background).id);
    return selection.choice.id;
  });
  const count = () =>
    page.evaluate(() => {
      const { cloud } = globalThis.freegsViewer.view;
      let chosen = 0;
      for (let i = 0; i < cloud.gaussians.count; ++i)
        chosen += cloud.isChosen(i);
      return chosen;
    });
  const own = await count();
  await page.getByRole("button", { name: "Wider" }).click();
  assert.ok((await count()) > own);
  await page.getByRole("button", { name: "Narrower" }).click();
  assert.equal(await count(), own);

  const download = async (name) => {
    const waiting = page.waitForEvent("download");
    await page.getByRole("button", { name }).click();
    const path = await (await waiting).path();
    return path;
  };
  const ply = readFileSync(await download("Save .ply"));
  const header = ply
    .subarray(0, ply.indexOf("end_header\n") + 11)
    .toString("latin1");
  assert.match(header, new RegExp(`element vertex ${own}\n`));
  assert.equal(ply.length, header.length + own * 17 * 4);
  // Far from the origin of the world, positions count from a point nearby.
  await page.evaluate(() => {
    globalThis.freegsScene.description.origin = [1.5e7, 0, 0];
  });
  const far = readFileSync(await download("Save .ply"));
  const start = far.indexOf("end_header\n") + 11;
  assert.match(
    far.subarray(0, start).toString("latin1"),
    /^comment offset 15000000 0 0$/m,
  );
  assert.ok(Math.abs(far.readFloatLE(start)) < 1e6);
  const mask = readGrey(await download("Save mask"));
  assert.ok(mask.values.some((value) => value === 255));
  // The file has the name of what was chosen when the picture was begun.
  const waiting = page.waitForEvent("download");
  const name = await page.locator(".v-details h3").innerText();
  await page.evaluate(() => {
    const buttons = [...document.querySelectorAll(".v-details button")];
    buttons.find((button) => button.textContent === "Save mask").click();
    globalThis.freegsViewer.selection.clear();
  });
  assert.equal((await waiting).suggestedFilename(), `${name}_${id}.png`);
  await page.evaluate((i) => globalThis.freegsViewer.selection.choose(i), id);

  await page.getByRole("button", { name: "Hide", exact: true }).click();
  assert.equal(
    await page.evaluate(
      (i) => globalThis.freegsViewer.selection.isVisible(i, 0),
      id,
    ),
    false,
  );
  await page.getByRole("button", { name: "Show all" }).click();
  assert.equal(
    await page.evaluate(
      (i) => globalThis.freegsViewer.selection.isVisible(i, 0),
      id,
    ),
    true,
  );
  assert.deepEqual(page.errors, []);
  await page.context().close();
});

test("wider adds what its level names, narrower takes away", async () => {
  const page = await openShared();
  // Object 1 has the parts 0 and 1, object 2 has part 2; 65535 is no part.
  const gaussians = [
    [1, 0],
    [1, 1],
    [1, 65535],
    [2, 2],
    [2, 65535],
    [0, 65535],
  ];
  const levels = await page.evaluate((labels) => {
    const Selection = globalThis.freegsViewer.selection.constructor;
    const selection = new Selection({
      objects: [],
      levels: { 1: { wider: [[0, 3]], narrower: [[0, 1]] } },
    });
    selection.choose(1, 0);
    return [0, 1, -2].map((direction) => {
      for (let i = 0; i < Math.abs(direction); ++i)
        selection.step(Math.sign(direction));
      return labels.map(([id, part]) => selection.isChosen(id, part));
    });
  }, gaussians);
  assert.deepEqual(levels, [
    [true, true, true, false, false, false],
    // All of the object that was clicked, and the parts of the other one.
    [true, true, true, true, false, false],
    [true, false, false, false, false, false],
  ]);
});

test("what changes while a part is made is seen in it", async () => {
  const page = await open();
  await settle(page);
  const script = readFileSync(join(dirname(scene.report), "scene.js"), "utf8");
  const { parts } = JSON.parse(/\{[^]*\}/.exec(script)[0]);
  const { painted, visible } = await page.evaluate(async (part) => {
    const { selection, view } = globalThis.freegsViewer;
    const { cloud } = view;
    const id = selection.scene.objects.find((o) => !o.background).id;
    const bytes = (text) =>
      Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    // The first part comes once more.
    cloud.gaussians.count = 0;
    await cloud.load(
      {
        description: { parts: [{}] },
        part: async () => {
          // After the view began to make the part, which takes it longer.
          setTimeout(() => {
            selection.setHidden(id, true);
            cloud.showFewer(true);
          });
          return {
            splats: bytes(part.splats),
            labels: new Uint16Array(bytes(part.labels).buffer),
          };
        },
      },
      () => {},
    );
    const { labels, state, mesh } = cloud.parts.at(-1);
    const found = new Set();
    for (let i = 0; 2 * i < labels.length; ++i)
      if (labels[2 * i] === id) found.add(state.array[4 * i + 3]);
    return { painted: [...found], visible: mesh.visible };
  }, parts[0]);
  assert.deepEqual(painted, [255]);
  assert.equal(visible, false);
  assert.deepEqual(page.errors, []);
  await page.context().close();
});

test("the page opens with the first view", async () => {
  const page = await open();
  const camera = () =>
    page.evaluate(() => {
      const { view } = globalThis.freegsViewer;
      return JSON.stringify(view.pinhole(view.width, view.height));
    });
  const opened = await camera();
  await page.locator(".v-canvas canvas").press("ArrowLeft");
  assert.notEqual(await camera(), opened);
  await page.getByRole("button", { name: "First view" }).click();
  assert.equal(await camera(), opened);
  await page.context().close();
});

test("photos fade in where the render is", async () => {
  const page = await openShared();
  await page.getByRole("button", { name: "▶" }).click();
  await page.getByLabel("Fade from the render to the photo").fill("60");
  const picture = page.locator(".v-photo");
  await picture.waitFor({ state: "visible" });
  assert.ok(
    (await picture.evaluate((img) =>
      img.decode().then(() => img.naturalWidth),
    )) > 0,
  );
  await settle(page);
  assert.deepEqual(page.errors, []);
});

test("no photo lies over the camera of another one", async () => {
  const page = await openPage(
    browser,
    writeGaussians(
      "slow",
      [{ mean: [0, 0, 0], scales: [0.5, 0.5, 0.5], opacity: 0.9 }],
      photo,
      ["a", "b", "c"].map((name) => `http://photos.example/${name}.svg`),
    ),
  );
  const waiting = new Map();
  await page.route("**/*.svg", (route) =>
    waiting.set(route.request().url().slice(-5), route),
  );
  const picture = page.locator(".v-photo");
  const come = async (name) => {
    for (let i = 0; i < 200 && !waiting.has(name); ++i)
      await page.waitForTimeout(20);
    await waiting.get(name).fulfill({
      contentType: "image/svg+xml",
      body: '<svg xmlns="http://www.w3.org/2000/svg" width="4" height="3"/>',
    });
  };
  const next = () => page.getByRole("button", { name: "▶" }).click();
  await next();
  await page.getByLabel("Fade from the render to the photo").fill("60");
  assert.equal(await picture.isVisible(), false);
  await come("a.svg");
  await picture.waitFor({ state: "visible" });
  await next();
  assert.equal(await picture.isVisible(), false);
  await next();
  await come("b.svg").catch(() => {}); // The page may have given it up.
  await page.waitForTimeout(100);
  assert.equal(await picture.isVisible(), false);
  await come("c.svg");
  await picture.waitFor({ state: "visible" });
  assert.match(await picture.getAttribute("src"), /c\.svg$/);
  await page.context().close();
});

test("fingers turn, come nearer and choose", async () => {
  const page = await open(
    { width: 390, height: 844 },
    { hasTouch: true, isMobile: true },
  );
  const canvas = page.locator(".v-canvas canvas");
  await canvas.scrollIntoViewIfNeeded();
  const box = await canvas.boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.touchscreen.tap(x, y);
  assert.ok((await chosen(page)) > 0);

  const session = await page.context().newCDPSession(page);
  const touch = (type, points) =>
    session.send("Input.dispatchTouchEvent", {
      type,
      touchPoints: points.map(([px, py], id) => ({ x: px, y: py, id })),
    });
  const pose = () =>
    page.evaluate(() => [
      ...globalThis.freegsViewer.view.pinhole(100, 100).translation,
    ]);
  const moved = async (strokes) => {
    const start = await pose();
    await touch("touchStart", strokes[0]);
    for (const points of strokes.slice(1)) await touch("touchMove", points);
    await touch("touchEnd", []);
    assert.notDeepEqual(await pose(), start);
  };
  await moved([[[x, y]], [[x + 30, y]], [[x + 60, y + 10]]]);
  const near = 30;
  await moved(
    [near, 2 * near, 3 * near].map((d) => [
      [x - d, y],
      [x + d, y],
    ]),
  );

  // Flying, a finger more does not turn the view; two come nearer.
  await page.getByRole("button", { name: "Fly" }).click();
  const camera = () =>
    page.evaluate(() => {
      const { view } = globalThis.freegsViewer;
      const { rotation, translation } = view.pinhole(100, 100);
      return { rotation: [...rotation], forward: -translation[2] };
    });
  const start = await camera();
  await touch("touchStart", [[x - near, y]]);
  const two = (d) => [
    [x - d, y],
    [x + d, y],
  ];
  await touch("touchStart", two(near));
  await touch("touchMove", two(near + 10));
  await touch("touchEnd", []);
  const nearer = await camera();
  assert.deepEqual(nearer.rotation, start.rotation);
  assert.ok(nearer.forward > start.forward);
  await page
    .locator(".v-canvas canvas")
    .dispatchEvent("wheel", { deltaY: 100 });
  assert.ok((await camera()).forward < nearer.forward);
  // So do the keys, and what one would turn around stays as far away.
  const distance = () =>
    page.evaluate(() => {
      const { navigation, camera: eye } = globalThis.freegsViewer.view;
      return eye.position.distanceTo(navigation.target);
    });
  const apart = await distance();
  await canvas.focus();
  let { forward } = await camera();
  const { radius } = await page.evaluate(
    () => globalThis.freegsScene.description,
  );
  for (const [key, step] of [
    ["+", 0.1],
    ["-", -0.1],
  ]) {
    for (let i = 0; i < 30; ++i) {
      await page.keyboard.press(key);
      const now = (await camera()).forward;
      assert.ok(Math.abs(now - forward - step * radius) < 1e-4 * radius);
      forward = now;
    }
  }
  assert.ok(Math.abs((await distance()) - apart) < 1e-4 * radius);
  assert.deepEqual(page.errors, []);
  await page.context().close();
});

test("a phone, and the keyboard alone", async () => {
  const page = await open({ width: 390, height: 844 });
  const width = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(width <= 390, `the page is ${width} wide`);
  // Tab to the canvas, turn, choose what is in the middle, go through its keys.
  for (let i = 0; i < 30; ++i) {
    if (await page.evaluate(() => document.activeElement?.tagName === "CANVAS"))
      break;
    await page.keyboard.press("Tab");
  }
  assert.equal(
    await page.evaluate(() => document.activeElement?.tagName),
    "CANVAS",
  );
  const position = () =>
    page.evaluate(() => [
      ...globalThis.freegsViewer.view.pinhole(100, 100).translation,
    ]);
  const before = await position();
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("+");
  assert.notDeepEqual(await position(), before);
  await page.keyboard.press("Enter");
  const id = await chosen(page);
  assert.ok(id > 0);
  await page.keyboard.press(".");
  // A wider region is no object that can be hidden.
  const region = await page.evaluate(
    () => globalThis.freegsViewer.selection.choice.region !== null,
  );
  if (region) await page.keyboard.press("h");
  assert.equal(await chosen(page), id);
  await page.keyboard.press("o");
  assert.equal(
    await page.evaluate(() => globalThis.freegsViewer.selection.isolated),
    true,
  );
  await page.keyboard.press("Escape");
  assert.equal(await chosen(page), 0);
  for (const key of ["i", "b", "c"]) await page.keyboard.press(key);
  assert.equal(await page.getByRole("button", { pressed: true }).count(), 3);
  // Keys come as near and go as far away as the wheel does.
  await page.locator(".v-canvas canvas").focus();
  for (const [key, limit] of [
    ["-", "maxDistance"],
    ["+", "minDistance"],
  ]) {
    const [distance, expected] = await page.evaluate(
      ([pressed, name]) => {
        const { camera, canvas, navigation } = globalThis.freegsViewer.view;
        for (let i = 0; i < 100; ++i)
          canvas.dispatchEvent(new KeyboardEvent("keydown", { key: pressed }));
        return [
          camera.position.distanceTo(navigation.target),
          navigation.orbit[name],
        ];
      },
      [key, limit],
    );
    assert.ok(Math.abs(distance / expected - 1) < 1e-6, `${key}: ${distance}`);
  }
  // The slider leaves keys to the page.
  const shown = () =>
    page.evaluate(() => globalThis.freegsViewer.view.photo?.name);
  await page.keyboard.press("]");
  const first = await shown();
  await page.getByLabel("Fade from the render to the photo").focus();
  await page.keyboard.press("]");
  assert.notEqual(await shown(), first);
  // The list by keyboard.
  await page.locator(".v-list button").first().focus();
  await page.keyboard.press("Enter");
  assert.ok((await chosen(page)) > 0);
  await settle(page);
  assert.deepEqual(page.errors, []);
  await page.context().close();
});

test("no serious finding of accessibility, light and dark", async () => {
  const page = await open();
  await page.evaluate(() => {
    const { objects } = globalThis.freegsScene.description;
    globalThis.freegsViewer.selection.choose(objects[0].id);
  });
  await page.evaluate(axe);
  for (const colorScheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme });
    const { violations } = await page.evaluate(() => globalThis.axe.run());
    const serious = violations
      .filter(({ impact }) => impact === "serious" || impact === "critical")
      .map(
        ({ id, nodes }) => `${id}: ${nodes.map((node) => node.html).join(" ")}`,
      );
    assert.deepEqual(serious, [], colorScheme);
  }
  await page.context().close();
});

test("without WebGL the page is whole and says why", async () => {
  const context = await browser.newContext();
  const page = await context.newPage();
  await page.addInitScript(() => {
    HTMLCanvasElement.prototype.getContext = () => null;
  });
  await page.goto(pathToFileURL(scene.report).href);
  await page.waitForFunction(
    () => document.querySelector("#scene3d")?.dataset.failed,
  );
  assert.match(await page.locator("#scene3d").innerText(), /no WebGL 2/);
  assert.ok((await page.locator(".strip img").count()) > 0);
  await context.close();
});

test("names are text, whatever they hold", async () => {
  // A workspace and photos with quotes, umlauts and markup in their names.
  const folder = join(
    build,
    "tests",
    "web",
    `"Tüte" <script>alert(1)<∕script> & 'x'`,
  );
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  const images = join(folder, "images");
  mkdirSync(images);
  const odd = `"ä" <img src=x onerror=alert(1)> 'ß'.png`;
  const transforms = JSON.parse(
    readFileSync(join(scene.truth, "gt", "transforms.json"), "utf8"),
  );
  transforms.frames = transforms.frames.filter((_, i) => i % 3 === 0);
  transforms.frames.forEach((frame, i) => {
    const old = frame.file_path.split("/").pop();
    const name = i === 0 ? odd : old;
    cpSync(join(scene.truth, "images", old), join(images, name));
    frame.file_path = frame.file_path.replace(old, name);
  });
  writeFileSync(join(folder, "transforms.json"), JSON.stringify(transforms));
  const workspace = join(folder, `w "<b>"`);
  runProgram(
    "run",
    images,
    workspace,
    "--sfm.import",
    join(folder, "transforms.json"),
    "--sfm.random_points",
    "10000",
    "--preset",
    "fast",
    "--reconstruct.iterations",
    "200",
    "--reconstruct.budget",
    "2000",
    "--bootstrap.mode",
    "geometry",
    "--export.report_views",
    "30",
  );
  const page = await openPage(
    browser,
    pathToFileURL(join(workspace, "export", "report", "index.html")).href,
  );
  assert.equal(await page.title(), `w "<b>"`);
  assert.ok(
    (await page.locator(".v-photobar option").allInnerTexts()).some((text) =>
      text.startsWith(`"ä"`),
    ),
  );
  await page.getByRole("button", { name: "▶" }).click();
  await settle(page);
  assert.equal(page.dialogs, 0);
  assert.equal(await page.locator("img[onerror]").count(), 0);
  assert.deepEqual(page.errors, []);
  await page.context().close();
});
