// SPDX-License-Identifier: BSD-3-Clause
// Bundles the page's script: node build.mjs OUT writes OUT/viewer.js,
// OUT/viewer.css, OUT/live.html and OUT/licenses.txt.

import { copyFile, mkdir, readFile, readdir, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, "dist");
await mkdir(out, { recursive: true });

const result = await build({
  absWorkingDir: here,
  entryPoints: { viewer: "src/main.ts" },
  outdir: out,
  bundle: true,
  // A classic script: browsers load no modules from the file system.
  format: "iife",
  target: "es2022",
  minify: true,
  legalComments: "none",
  metafile: true,
  logLevel: "warning",
});

// The licences of all packages of which something is in the bundle.
const packages = new Set();
for (const input of Object.keys(result.metafile.inputs)) {
  const match = /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(input);
  if (match) packages.add(match[1]);
}
// Packages also come with parts of those that they depend on.
for (const name of packages) {
  const file = join(here, "node_modules", name, "package.json");
  const { dependencies = {} } = JSON.parse(await readFile(file, "utf8"));
  for (const dependency of Object.keys(dependencies)) packages.add(dependency);
}
let licenses = "viewer.js and viewer.css hold parts of these packages.\n";
for (const name of [...packages].sort()) {
  const folder = join(here, "node_modules", name);
  const { version, license } = JSON.parse(
    await readFile(join(folder, "package.json"), "utf8"),
  );
  const file = (await readdir(folder)).find((entry) => /^licen[sc]e/i.test(entry));
  const text = file
    ? (await readFile(join(folder, file), "utf8")).trim()
    : `Its package names the licence ${license} and has no text of it.`;
  licenses += `\n== ${name} ${version} (${license})\n\n${text}\n`;
}
await writeFile(join(out, "licenses.txt"), licenses);
await copyFile(join(here, "live.html"), join(out, "live.html"));
