// SPDX-License-Identifier: BSD-3-Clause
// Bundles the scripts of the pages: node build.mjs OUT writes OUT/viewer.js,
// OUT/viewer.css, OUT/live.html, OUT/bench.js and OUT/licenses.txt.

import { copyFile, mkdir, readFile, readdir, stat, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, "dist");
await mkdir(out, { recursive: true });

const result = await build({
  absWorkingDir: here,
  entryPoints: { viewer: "src/main.ts", bench: "src/bench/main.ts" },
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
let licenses = "viewer.js, viewer.css and bench.js hold parts of these packages.\n";
for (const name of [...packages].sort()) {
  const folder = join(here, "node_modules", name);
  const { version, license } = JSON.parse(
    await readFile(join(folder, "package.json"), "utf8"),
  );
  // LICENSE, NOTICE, and folders of licences of what a package has taken over.
  const files = (await readdir(folder, { recursive: true })).filter((path) =>
    /^(licen[sc]e|notice)/i.test(path),
  );
  const texts = [];
  for (const file of files.sort()) {
    const path = join(folder, file);
    if ((await stat(path)).isFile()) texts.push(await readFile(path, "utf8"));
  }
  const text =
    texts.length > 0
      ? texts.join("\n").trim()
      : `Its package names the licence ${license} and has no text of it.`;
  licenses += `\n== ${name} ${version} (${license})\n\n${text}\n`;
}
await writeFile(join(out, "licenses.txt"), licenses);
await copyFile(join(here, "live.html"), join(out, "live.html"));
