// SPDX-License-Identifier: BSD-3-Clause
// node run.mjs BUILD TEST.mjs: runs a test of the page, or skips it (77) where
// there is no Chromium or where the page was not built.

import { spawnSync } from "node:child_process";
import { existsSync } from "node:fs";
import { delimiter, join } from "node:path";

const [build, test] = process.argv.slice(2);
const folders = (process.env.PATH ?? "").split(delimiter);
const chromium = [process.env.CHROMIUM ?? ""]
  .concat(
    [
      "chromium-headless-shell", // Has no windows, and takes three quarters of the time.
      "chromium",
      "chromium-browser",
      "google-chrome",
    ].flatMap((name) => folders.map((folder) => join(folder, name))),
  )
  .find((path) => existsSync(path));
if (!chromium) {
  console.log(
    "[  SKIPPED ] there is no Chromium (Debian: chromium-headless-shell; or set CHROMIUM)",
  );
  process.exit(77);
}
if (!existsSync(join(build, "share", "freegs_pipeline", "web", "viewer.js"))) {
  console.log("[  SKIPPED ] the page is not built (FREEGS_BUILD_WEB)");
  process.exit(77);
}
const result = spawnSync(process.execPath, ["--test", test], {
  stdio: "inherit",
  env: { ...process.env, PAGE_TEST_BUILD: build, PAGE_TEST_CHROMIUM: chromium },
});
process.exit(result.status ?? 1);
