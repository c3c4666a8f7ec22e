// SPDX-License-Identifier: BSD-3-Clause
// The page through `freegs_pipeline view`: words, pictures and a run under way.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import {
  existsSync,
  mkdirSync,
  readFileSync,
  readdirSync,
  rmSync,
  utimesSync,
} from "node:fs";
import { dirname, join } from "node:path";
import { after, before, test } from "node:test";

import {
  makeScene,
  openBrowser,
  openPage,
  program,
  runProgram,
  settle,
} from "./support.mjs";

let scene;
let browser;
const children = [];

before(async () => {
  scene = makeScene();
  browser = await openBrowser();
});

after(async () => {
  await browser?.close();
  for (const child of children) child.kill("SIGKILL");
});

/** Starts the server; the address that it prints. */
async function serve(workspace) {
  const child = spawn(program, ["view", workspace, "--port", "0"], {
    stdio: ["ignore", "pipe", "inherit"],
  });
  children.push(child);
  let text = "";
  for await (const chunk of child.stdout) {
    text += chunk;
    const match = /http:\/\/\S+/.exec(text);
    if (match) return { child, url: match[0] };
  }
  throw new Error(`no address: ${text}`);
}

async function stop(child) {
  const ended = new Promise((resolve) => child.once("exit", resolve));
  const start = Date.now();
  child.kill("SIGINT");
  await ended;
  return Date.now() - start;
}

const answer = (...args) =>
  JSON.parse(runProgram("query", scene.workspace, ...args, "--json"));

test("three questions in words, and one by a picture", async () => {
  const { child, url } = await serve(scene.workspace);
  const page = await openPage(browser, url);
  const bar = page.locator("[data-milliseconds]");
  const ask = async (text) => {
    await page.getByLabel("Words that say what is sought").fill(text);
    await page.evaluate(() =>
      document
        .querySelector("[data-milliseconds]")
        ?.removeAttribute("data-milliseconds"),
    );
    await page.getByRole("button", { name: "Ask", exact: true }).click();
    await bar.waitFor();
    return {
      best: Number((await bar.getAttribute("data-best")) || 0),
      milliseconds: Number(await bar.getAttribute("data-milliseconds")),
    };
  };
  const times = [];
  for (const text of ["traffic cone", "red ball", "brick"]) {
    const { best, milliseconds } = await ask(text);
    const expected = answer("--text", text);
    assert.equal(best, expected.found ? expected.hits[0].id : 0, text);
    if (expected.found) {
      assert.equal(
        await page.evaluate(() => globalThis.freegsViewer.selection.choice.id),
        best,
      );
    }
    times.push(milliseconds);
  }
  console.log(`# answers in words: ${times.join(", ")} ms`);

  // A picture of what is sought, dropped on the page.
  const folder = join(scene.truth, "images");
  const example = join(folder, readdirSync(folder).sort()[0]);
  await page.evaluate(
    (bytes) => {
      document
        .querySelector("[data-milliseconds]")
        .removeAttribute("data-milliseconds");
      const data = new DataTransfer();
      data.items.add(
        new File([Uint8Array.from(bytes)], "example.png", {
          type: "image/png",
        }),
      );
      document.dispatchEvent(
        new DragEvent("drop", {
          dataTransfer: data,
          bubbles: true,
          cancelable: true,
        }),
      );
    },
    [...readFileSync(example)],
  );
  await bar.waitFor();
  const expected = answer("--example", example);
  assert.equal(
    Number(await bar.getAttribute("data-best")),
    expected.found ? expected.hits[0].id : 0,
  );
  assert.deepEqual(page.errors, []);
  await page.context().close();
  assert.ok((await stop(child)) < 2000);
});

test("doubts are shown, and a late answer replaces no newer one", async () => {
  const { child, url } = await serve(scene.workspace);
  const page = await openPage(browser, url);
  const asked = [];
  await page.route("**/api/query*", (route) => asked.push(route));
  const ask = async (text) => {
    const request = page.waitForRequest("**/api/query*");
    await page.getByLabel("Words that say what is sought").fill(text);
    await page.getByRole("button", { name: "Ask", exact: true }).click();
    await request;
  };
  const answerTo = async (text, note) => {
    const route = asked.find((r) => r.request().postDataJSON().text === text);
    const answered = page.waitForResponse(
      (response) => response.request() === route.request(),
    );
    await route.fulfill({
      json: {
        ...{ found: false, score: "relevancy", threshold: 0.5, hits: [] },
        ...{ others: [], best_score: null, note },
      },
    });
    await (await answered).finished();
    // The page has had the time to show it.
    await page.evaluate(
      () => new Promise((resolve) => setTimeout(resolve, 100)),
    );
  };
  const note = page.locator(".v-note");
  await ask("early");
  await ask("late");
  await answerTo("late", "query: this is <b>a guess</b>\n");
  assert.equal(await note.innerText(), "this is <b>a guess</b>");
  await answerTo("early", "query: an old answer\n");
  assert.equal(await note.innerText(), "this is <b>a guess</b>");
  await ask("sure");
  await answerTo("sure", "");
  assert.equal(await note.count(), 0);
  assert.deepEqual(page.errors, []);
  await page.context().close();
  await stop(child);
});

test("two viewers, photos and whole objects from the server", async () => {
  const { child, url } = await serve(scene.workspace);
  const [first, second] = await Promise.all([
    openPage(browser, url),
    openPage(browser, url, { width: 390, height: 844 }),
  ]);
  const id = await first.evaluate(() => {
    const { selection } = globalThis.freegsViewer;
    selection.choose(
      selection.scene.objects.find((object) => !object.background).id,
    );
    return selection.choice.id;
  });
  const waiting = first.waitForEvent("download");
  await first.getByRole("button", { name: "Save .ply" }).click();
  const download = await waiting;
  const saved = readFileSync(await download.path());
  // The name is the one that the report gives, too.
  const name = await first.locator(".v-details h3").innerText();
  assert.equal(download.suggestedFilename(), `${name}_${id}.ply`);
  const exported = join(dirname(scene.workspace), "object.ply");
  runProgram(
    "export",
    scene.workspace,
    "--out",
    exported,
    "--only",
    String(id),
  );
  assert.ok(saved.equals(readFileSync(exported)));

  // Every photo can be faded in, not only those of the report.
  const photos = await second.evaluate(
    () => globalThis.freegsViewer.selection.scene.photos.length,
  );
  await second
    .getByLabel("Photo", { exact: true })
    .selectOption(String(photos - 1));
  await second.getByLabel("Fade from the render to the photo").fill("100");
  const width = await second
    .locator(".v-photo")
    .evaluate((img) => img.decode().then(() => img.naturalWidth));
  assert.ok(width > 0);
  await settle(second);
  for (const page of [first, second]) {
    assert.deepEqual(page.errors, []);
    await page.context().close();
  }
  await stop(child);
});

test("the page is loaded anew when the objects are others", async () => {
  const { child, url } = await serve(scene.workspace);
  const page = await openPage(browser, url);
  await page.evaluate(() => (globalThis.isOld = true));
  utimesSync(
    join(scene.workspace, "bootstrap", "instances.json"),
    new Date(),
    new Date(),
  );
  await page.waitForFunction(() => !globalThis.isOld);
  await page.context().close();
  await stop(child);
});

test("a run under way is shown until its scene is there", async () => {
  const workspace = join(dirname(scene.workspace), "live");
  rmSync(workspace, { recursive: true, force: true });
  mkdirSync(workspace, { recursive: true });
  const { child, url } = await serve(workspace);
  const page = await browser.newPage();
  const errors = [];
  page.on("pageerror", (error) => errors.push(String(error)));
  page.setDefaultTimeout(180000);
  await page.goto(url);
  const run = spawn(
    program,
    [
      "run",
      join(scene.truth, "images"),
      workspace,
      "--sfm.import",
      join(scene.truth, "gt", "transforms.json"),
      "--sfm.random_points",
      "10000",
      "--preset",
      "fast",
      "--reconstruct.iterations",
      "300",
      "--reconstruct.budget",
      "5000",
    ],
    { stdio: "ignore" },
  );
  children.push(run);
  // The page asks every two seconds. The run waits until it has seen the picture.
  while (run.exitCode === null && !existsSync(join(workspace, "preview.jpg")))
    await new Promise((resolve) => setTimeout(resolve, 5));
  run.kill("SIGSTOP");
  await page.locator("#live [data-state='running']").first().waitFor();
  await page.locator(".v-preview").waitFor({ state: "visible" });
  assert.ok(
    (await page.locator(".v-preview").evaluate((img) => img.naturalWidth)) > 0,
  );
  run.kill("SIGCONT");
  // In the end the report takes its place.
  await page.waitForFunction(
    () => document.querySelector("#scene3d")?.dataset.loaded,
  );
  assert.ok(existsSync(join(workspace, "export", "report", "index.html")));
  assert.deepEqual(errors, []);
  await page.close();
  await stop(child);
});
