// SPDX-License-Identifier: BSD-3-Clause
// The style sheet of the report; it has a light and a dark variant.

#ifndef FREEGS_STAGES_EXPORT_REPORT_STYLE_H_
#define FREEGS_STAGES_EXPORT_REPORT_STYLE_H_

#include <string_view>

namespace freegs::stages {

inline constexpr std::string_view kReportStyle = R"css(
:root {
  color-scheme: light dark;
  --page: #fbfaf8; --card: #ffffff; --line: #e4e1db; --edge: #8d8a83;
  --text: #23211e; --quiet: #6d6961; --accent: #1f6f8b; --warn: #9a5b00;
}
@media (prefers-color-scheme: dark) {
  :root {
    --page: #17181a; --card: #1f2123; --line: #34373a; --edge: #7b7f83;
    --text: #e8e6e2; --quiet: #9d9a94; --accent: #6fc0dc; --warn: #e0a85a;
  }
}
* { box-sizing: border-box; }
body {
  margin: 0; background: var(--page); color: var(--text);
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif;
}
main { max-width: 72rem; margin: 0 auto; padding: 2rem 1rem 4rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; margin: 2.8rem 0 .8rem; }
p { margin: .3rem 0; max-width: 46rem; }
a { color: var(--accent); }
.quiet, figcaption, th { color: var(--quiet); }
.warning { color: var(--warn); }
.figures {
  display: grid; gap: .75rem; margin: 1.6rem 0 0; padding: 0;
  grid-template-columns: repeat(auto-fill, minmax(8.6rem, 1fr));
}
.figures > div {
  background: var(--card); border: 1px solid var(--line);
  border-radius: .5rem; padding: .7rem .9rem;
}
.figures dt { color: var(--quiet); font-size: .82rem; }
.figures dd { margin: 0; }
.figures .value {
  font-size: 1.35rem; line-height: 1.35; font-variant-numeric: tabular-nums;
}
.figures .note { color: var(--quiet); font-size: .82rem; }
.view { margin: 0 0 1.6rem; }
.view h3 {
  font-size: .95rem; font-weight: 600; margin: 0 0 .35rem;
  overflow-wrap: anywhere;
}
.view h3 span { font-weight: 400; color: var(--quiet); }
.strip { display: grid; gap: .5rem; grid-template-columns: repeat(5, 1fr); }
.strip figure { margin: 0; min-width: 0; }
.strip img {
  display: block; width: 100%; height: auto; border-radius: .25rem;
  background: var(--line);
}
.strip .nothing {
  display: grid; place-items: center; aspect-ratio: 4 / 3; color: var(--quiet);
  border: 1px dashed var(--line); border-radius: .25rem; font-size: .82rem;
}
figcaption { font-size: .78rem; margin-top: .15rem; }
.charts {
  display: grid; gap: 1.5rem;
  grid-template-columns: repeat(auto-fit, minmax(17rem, 1fr));
}
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td {
  padding: .35rem 1.2rem .35rem 0; text-align: left; vertical-align: baseline;
  border-bottom: 1px solid var(--line);
}
th { font-weight: 400; font-size: .85rem; }
.number { text-align: right; }
.swatch {
  display: inline-block; width: .95rem; height: .95rem; border-radius: .2rem;
  vertical-align: -.12rem; margin-right: .5rem;
}
footer { margin-top: 3rem; color: var(--quiet); font-size: .85rem; }
@media (max-width: 46rem) {
  main { padding-top: 1.2rem; }
  .figures { grid-template-columns: repeat(2, 1fr); }
  .strip { grid-template-columns: repeat(2, 1fr); }
}
)css";

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_REPORT_STYLE_H_
