// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bench/bench_page.h"

#include "stages/export/html.h"

namespace freegs::stages {
namespace {

constexpr std::string_view kStyle = R"css(
:root { color-scheme: light; --line: #e4e1db; --text: #23211e;
  --quiet: #6d6961; --accent: #1f6f8b; --warn: #9a5b00; }
* { box-sizing: border-box; }
body { margin: 0; background: #fbfaf8; color: var(--text);
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif; }
main { max-width: 76rem; margin: 0 auto; padding: 2rem 1rem 4rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0; }
h2 { font-size: 1.15rem; margin: 2.4rem 0 .6rem; }
.quiet { color: var(--quiet); }
.warning { color: var(--warn); }
.chart { width: 100%; height: 30rem; background: #fff;
  border: 1px solid var(--line); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: .9rem; background: #fff; }
th, td { border: 1px solid var(--line); padding: .25rem .6rem;
  text-align: left; white-space: nowrap; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
td.reason { white-space: normal; min-width: 24rem; overflow-wrap: anywhere; }
tr.failed td { color: var(--warn); }
pre { overflow-x: auto; }
)css";

}  // namespace

std::string RenderBenchPage(const BenchPage& page) {
  std::string html =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\">\n<title>" +
      EscapeHtml(page.title) + "</title>\n<style>" + std::string(kStyle) +
      "</style>\n</head>\n<body>\n<main>\n<h1>" + EscapeHtml(page.title) +
      "</h1>\n<div id=\"bench\">\n";
  if (page.script.empty()) {
    html += "<p class=\"warning\">" + EscapeHtml(page.missing) + "</p>\n";
  }
  html += "<pre>" + EscapeHtml(page.summary) + "</pre>\n</div>\n</main>\n";
  if (!page.script.empty()) {
    html += "<script type=\"application/json\" id=\"results\">" +
            JsonForScript(page.results) + "</script>\n<script>" + page.script +
            "</script>\n";
  }
  return html + "</body>\n</html>\n";
}

}  // namespace freegs::stages
