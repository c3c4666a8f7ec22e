// SPDX-License-Identifier: BSD-3-Clause
// Options and the records of stages.

#include <string>
#include <vector>

#include "core/io/json_fields.h"
#include "pipeline/option_table.h"
#include "pipeline/stage_record.h"
#include "tests/fuzz/reader.h"

namespace freegs::fuzz {
namespace {

// Options of every kind.
struct Values {
  bool flag = false;
  int count = 3;
  int64_t seed = 0;
  double share = 0.5;
  std::string choice = "one";
  std::string path;
};

pipeline::OptionTable MakeTable(Values* values) {
  pipeline::OptionTable table;
  table.AddSection("a", "A section.");
  table.Add("a.flag", &values->flag, {.help = "A switch."});
  table.Add("a.count", &values->count, {.help = "A count.", .min = 0});
  table.Add("a.seed", &values->seed, {.help = "A seed.", .min = 0});
  table.Add(
      "b.share", &values->share, {.help = "A share.", .min = 0, .max = 1});
  table.Add("b.choice",
            &values->choice,
            {.help = "A choice.", .choices = {"one", "two"}});
  table.Add("path", &values->path, {.help = "A path.", .is_path = true});
  table.AddAlias("seed", "a.seed");
  return table;
}

// What is accepted must have a value that can be written and read again.
void ApplyAndWrite(const std::vector<pipeline::OptionSetting>& settings) {
  Values values;
  pipeline::OptionTable table = MakeTable(&values);
  if (!table.Apply(settings).ok()) return;
  Require(values.count >= 0 && values.seed >= 0);
  Require(values.share >= 0 && values.share <= 1);
  Require(values.choice == "one" || values.choice == "two");
}

}  // namespace

// Arguments stand one per line.
Reader CommandLine() {
  return {[](std::string_view bytes) {
            std::vector<std::string> arguments;
            while (!bytes.empty()) {
              const size_t end = bytes.find('\n');
              arguments.emplace_back(bytes.substr(0, end));
              bytes.remove_prefix(end == std::string_view::npos ? bytes.size()
                                                                : end + 1);
            }
            Values values;
            const auto line = MakeTable(&values).ParseCommandLine(arguments);
            if (line.ok()) ApplyAndWrite(line->settings);
          },
          [] {
            return std::vector<std::string>{
                "run\nimages\n--a.count\n7\n--seed=12\n--a.flag\nworkspace",
                "--b.share\n0.25\n--b.choice\ntwo\n--path\nx\n--",
                "--a.flag=false\n--a.cuont\n1"};
          }};
}

Reader ConfigFile() {
  return {[](std::string_view bytes) {
            Values values;
            const auto settings = MakeTable(&values).ParseConfig(
                std::string(bytes), "/folder", "config.ini");
            if (settings.ok()) ApplyAndWrite(*settings);
          },
          [] {
            Values values;
            return std::vector<std::string>{
                MakeTable(&values).ConfigTemplate(),
                "[a]\nflag = true\ncount = 7\nseed=1 ; why\n\n# no\n"
                "[b]\nshare = 1e-3\nchoice = two\n"};
          }};
}

Reader StageRecord() {
  return {[](std::string_view bytes) {
            const auto json = ParseJson(bytes);
            if (!json.ok()) return;
            const auto record = pipeline::RecordFromJson(*json);
            if (!record.ok()) return;
            const auto again =
                pipeline::RecordFromJson(pipeline::ToJson(*record));
            Require(again.ok());
            Require(again->fingerprint == record->fingerprint);
          },
          [] {
            pipeline::StageRecord record;
            record.fingerprint.stage = "sfm";
            record.fingerprint.options = {{"sfm.matcher", "exhaustive"}};
            record.fingerprint.inputs["ingest"] = {};
            record.outcome = pipeline::StageOutcome::kFailed;
            record.error_code = StatusCode::kBadInput;
            record.error = "no \"photos\"";
            record.summary["registered"] = 12;
            return std::vector<std::string>{pipeline::ToJson(record).dump()};
          }};
}

}  // namespace freegs::fuzz
