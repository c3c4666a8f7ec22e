// SPDX-License-Identifier: BSD-3-Clause
// The page for programs that were built without the 3D viewer: the state of the
// workspace as text.

#ifndef FREEGS_STAGES_VIEW_FALLBACK_PAGE_H_
#define FREEGS_STAGES_VIEW_FALLBACK_PAGE_H_

namespace freegs::stages {

inline constexpr char kFallbackPage[] = R"html(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>FreeGS</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
body { font: 16px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 44rem;
  padding: 0 1rem; color-scheme: light dark; }
td { padding: 0 1.5rem 0 0; } img { max-width: 100%; margin-top: 1rem; }
</style></head><body>
<h1 id="name">FreeGS</h1>
<p>The 3D viewer was not built into this program. This page shows what happens
in the workspace; the report appears when it is done.</p>
<p id="now"></p><table id="stages"></table><img id="preview" alt="" hidden>
<script>
const at = (id) => document.getElementById(id);
async function show() {
  try {
    const state = await (await fetch("/api/status")).json();
    at("name").textContent = state.workspace;
    const p = state.progress;
    at("now").textContent = !state.running ? "No run is under way." :
      !p ? "A run is under way." : p.stage + ": " + p.step +
      (p.total > 0 ? " " + Math.floor(p.done) + " of " + p.total : "") +
      (p.seconds_left !== null ? ", " + Math.ceil(p.seconds_left) +
      " s left" : "");
    at("stages").replaceChildren(...state.stages.map((stage) => {
      const row = document.createElement("tr");
      for (const text of [stage.name, stage.state, stage.wall_seconds === null ?
          "" : stage.wall_seconds.toFixed(1) + " s"]) {
        row.appendChild(document.createElement("td")).textContent = text;
      }
      return row;
    }));
    at("preview").hidden = !state.preview;
    if (state.preview) at("preview").src = state.preview;
    if (!state.running && state.export_version) location.reload();
  } catch (error) {
    at("now").textContent = "The server does not answer.";
  }
  setTimeout(show, 2000);
}
show();
</script></body></html>
)html";

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_FALLBACK_PAGE_H_
