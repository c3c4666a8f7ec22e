// SPDX-License-Identifier: BSD-3-Clause
// The page of a bench: its charts and tables, in one file that opens from the
// file system.

#ifndef FREEGS_STAGES_BENCH_BENCH_PAGE_H_
#define FREEGS_STAGES_BENCH_BENCH_PAGE_H_

#include <string>
#include <string_view>

namespace freegs::stages {

struct BenchPage {
  std::string title;
  std::string results;  // The text of results.json.
  std::string summary;  // The tables in Markdown, for readers without script.

  // bench.js, which web/build.mjs makes. Empty when the page was not built;
  // then `missing` says so.
  std::string script;
  std::string missing;
};

std::string RenderBenchPage(const BenchPage& page);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BENCH_BENCH_PAGE_H_
