// SPDX-License-Identifier: BSD-3-Clause
// The page of a bench as a file, and its chart as an SVG.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";

import { axe, build, openBrowser, runProgram } from "./support.mjs";

const folder = join(build, "tests", "web", "bench");
const out = join(folder, "out");
let browser;

before(async () => {
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  writeFileSync(
    join(folder, "suite.ini"),
    `[suite]
title = A <suite> & its page
seeds = 1 2
to = reconstruct
reconstruct.exposure = off
reconstruct.max_image_size = 160
reconstruct.iterations = 60
sfm.import = \${scene}/gt/transforms.json
sfm.random_points = 10000
[scene table]
draw = --views 12 --test_views 2 --width 160 --height 120
[grid presets]
preset = fast quality
[grid broken]
sfm.import = \${scene}/gt/missing.json
[chart speed]
title = Speed
x = reconstruct.cpu_seconds
y = psnr
log_x = true
[table all]
title = Means
columns = psnr scene_bytes
`,
  );
  runProgram("bench", join(folder, "suite.ini"), "--out", out);
  browser = await openBrowser();
});

after(() => browser?.close());

test("charts, tables and failures, from the file system", async () => {
  const page = await browser.newPage({
    viewport: { width: 1200, height: 900 },
  });
  const errors = [];
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("console", (message) => {
    if (message.type() === "error") errors.push(message.text());
  });
  await page.goto(pathToFileURL(join(out, "index.html")).href);
  assert.equal(await page.locator("h1").textContent(), "A <suite> & its page");
  assert.match(
    await page.locator("p.quiet").first().textContent(),
    /^4 of 6 experiments done, 2 failed/,
  );
  assert.equal(await page.locator(".chart svg").count(), 1);

  /** Points at a place of a chart; what the page says of it. */
  const hover = async (finder, value, wanted) => {
    const [x, y] = await page.evaluate(
      ([axes, at]) => globalThis.freegsBench.charts[0].convertToPixel(axes, at),
      [finder, value],
    );
    const box = await page.locator(".chart").boundingBox();
    await page.mouse.move(box.x + x - 30, box.y + y);
    await page.mouse.move(box.x + x, box.y + y, { steps: 4 });
    const tip = page.locator(".chart > div").filter({ hasText: wanted });
    await tip.waitFor({ timeout: 5000 });
    return tip.innerText();
  };
  const option = await page.evaluate(() => {
    const { series } = globalThis.freegsBench.charts[0].getOption();
    return series.map(({ name, type, data }) => ({
      name,
      type,
      values: data.map((item) => item.value ?? item),
    }));
  });
  const point = option.find(({ type }) => type === "line").values[0];
  const told = await hover({ seriesIndex: 0 }, point, "2 of 2 runs");
  assert.match(told, /preset (fast|quality)/);
  const failed = option.findIndex(({ name }) => name === "failed");
  assert.equal(option[failed].values.length, 2);
  const reason = "failed in sfm with exit code 3";
  await hover({ seriesIndex: failed }, option[failed].values[0], reason);

  assert.equal(await page.locator("tr.failed").count(), 2);
  assert.match(
    await page.locator("tr.failed").first().innerText(),
    /missing\.json: no such file/,
  );
  await page.screenshot({ path: join(folder, "page.png"), fullPage: true });
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => globalThis.axe.run());
  assert.deepEqual(
    violations.map(({ id, nodes }) => [id, nodes[0].html]),
    [],
  );
  assert.deepEqual(errors, []);
  await page.close();
});

/** The page with results that were changed, as a file of this name. */
function changedPage(name, change) {
  const html = readFileSync(join(out, "index.html"), "utf8");
  const file = join(out, name);
  writeFileSync(
    file,
    html.replace(/(?<=id="results">)[^]*?(?=<\/script>)/, (json) => {
      const results = JSON.parse(json);
      change(results);
      return JSON.stringify(results).replaceAll("<", "\\u003c");
    }),
  );
  return pathToFileURL(file).href;
}

test("figures of failed runs count only among themselves", async () => {
  const address = changedPage("totals.html", (results) => {
    results.tables[0].columns = ["total.cpu_seconds", "sfm.cpu_seconds"];
    const ofGrid = (grid) => results.cells.filter((cell) => cell.grid === grid);
    const [cut, whole] = ofGrid("presets").filter(
      (cell) => cell.point.preset === "fast",
    );
    cut.status = "failed";
    cut.values = { "total.cpu_seconds": 9, "sfm.cpu_seconds": 7 };
    whole.values = { "total.cpu_seconds": 40, "sfm.cpu_seconds": 8 };
    for (const cell of ofGrid("broken")) {
      cell.values = { "total.cpu_seconds": 9 };
    }
  });
  const page = await browser.newPage();
  await page.goto(address);
  const rows = page.locator("table").first().locator("tbody tr");
  const figures = (text) =>
    rows.filter({ hasText: text }).locator("td.number").allTextContents();
  assert.deepEqual(await figures("fast"), ["40 (1 of 2)", "8 (1 of 2)"]);
  assert.deepEqual(await figures("broken"), ["9", ""]);
  await page.close();
});

test("each row has what was said, and the reason once", async () => {
  let done;
  let failed;
  const address = changedPage("said.html", (results) => {
    const index = (status) =>
      results.cells.findIndex((cell) => cell.status === status);
    done = index("done");
    failed = index("failed");
    results.cells[done].said = ["warning: few poses"];
    results.cells[failed].reason = "sfm: no poses";
    results.cells[failed].said = [
      "warning: dark photos",
      "freegs_pipeline: sfm: no poses",
    ];
  });
  const page = await browser.newPage();
  await page.goto(address);
  const rows = page.locator("table").last().locator("tbody tr");
  const lines = (row) => rows.nth(row).locator("td > div").allTextContents();
  assert.deepEqual(await lines(done), ["warning: few poses"]);
  assert.deepEqual(await lines(failed), [
    "sfm: no poses",
    "warning: dark photos",
  ]);
  await page.close();
});

test("the same chart as an SVG, and one of a table", () => {
  const plot = (...args) =>
    execFileSync(process.execPath, [join(build, "web", "plot.mjs"), ...args], {
      stdio: "pipe",
    });
  const file = join(folder, "speed.svg");
  plot(join(out, "results.json"), "--chart", "speed", "--out", file);
  const svg = readFileSync(file, "utf8");
  assert.match(svg, /^<svg/);
  assert.match(svg, />Speed</);
  assert.match(svg, />fast</);

  const table = join(folder, "table.csv");
  writeFileSync(table, 'name,s,e\nfirst,1,0.5\n"second, it",2,0.4\nthird,3,\n');
  plot(`ours=${table}`, "--x=s", "--y=e", "--label=name", "--out", file);
  const drawn = readFileSync(file, "utf8");
  assert.match(drawn, />second, it</);
  assert.match(drawn, />1 failed</);
  assert.throws(() => plot(`ours=${table}`, "--out", file));
});
