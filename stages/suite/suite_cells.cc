// SPDX-License-Identifier: BSD-3-Clause

#include "stages/suite/suite_cells.h"

#include <algorithm>
#include <utility>

#include "pipeline/option_table.h"
#include "pipeline/workspace.h"
#include "stages/registry/pipeline_options.h"
#include "stages/registry/stage_registry.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxCells = 10000;
constexpr char kEvalPrefix[] = "eval.";
constexpr char kDisturb[] = "disturb";
constexpr char kSceneVariable[] = "${scene}";

// Checks settings, and adds them to cells.
class SettingTaker {
 public:
  SettingTaker(const Suite& suite, const SuiteChecks& checks)
      : suite_(suite), checks_(checks), table_(MakeOptionTable(&options_)) {}

  // The setting by its full name and with an absolute path, checked. `where` is
  // the section.
  StatusOr<SuiteSetting> Checked(const SuiteSetting& given,
                                 const std::string& where) {
    const std::string& key = given.first;
    const std::string& value = given.second;
    const auto fault = [&](const Status& status) {
      return status.Annotated(suite_.name + ": " + where + " " + key);
    };
    if (key.starts_with(kEvalPrefix) && checks_.eval) {
      const StatusOr<bool> is_path = checks_.eval(EvalOption(key), value);
      if (!is_path.ok()) return fault(is_path.status());
      return SuiteSetting{key, *is_path ? AbsolutePath(value) : value};
    }
    if (key == kDisturb && checks_.disturb) {
      const Status status = checks_.disturb(value);
      if (!status.ok()) return fault(status);
      return given;
    }
    const auto alias = table_.aliases().find(key);
    SuiteSetting setting{alias == table_.aliases().end() ? key : alias->second,
                         value};
    if (setting.first == "general.seed") {
      return fault(InvalidArgumentError("[suite] seeds = ... gives the seeds"));
    }
    FREEGS_RETURN_IF_ERROR(
        table_.Apply({{setting.first, value, suite_.name + ": " + where}}));
    if (table_.Find(setting.first)->spec.HasPath(value)) {
      setting.second = AbsolutePath(value);
    }
    return setting;
  }

  static std::string EvalOption(const std::string& key) {
    std::string name = key.substr(sizeof(kEvalPrefix) - 1);
    std::replace(name.begin(), name.end(), '_', '-');
    return name;
  }

  StatusOr<std::vector<SuiteSetting>> AllChecked(
      const std::vector<SuiteSetting>& given, const std::string& where) {
    std::vector<SuiteSetting> settings;
    for (const SuiteSetting& setting : given) {
      FREEGS_ASSIGN_OR_RETURN(SuiteSetting checked, Checked(setting, where));
      settings.push_back(std::move(checked));
    }
    return settings;
  }

 private:
  // A path with ${scene} becomes absolute when the folder of the scene is
  // known.
  std::string AbsolutePath(const std::string& value) const {
    if (value.empty() || value.find(kSceneVariable) != std::string::npos) {
      return value;
    }
    return pipeline::AbsolutePath(suite_.folder / value).string();
  }

  const Suite& suite_;
  const SuiteChecks& checks_;
  PipelineOptions options_;
  pipeline::OptionTable table_;
};

void AddSettings(const std::vector<SuiteSetting>& settings, SuiteCell* cell) {
  for (const SuiteSetting& setting : settings) {
    if (setting.first.starts_with(kEvalPrefix)) {
      cell->eval_options[SettingTaker::EvalOption(setting.first)] =
          setting.second;
    } else if (setting.first == kDisturb) {
      cell->disturb = setting.second == "none" ? "" : setting.second;
    } else {
      cell->settings.push_back(setting);
    }
  }
}

// A point of a grid: as it was written, and checked.
struct GridPoint {
  std::vector<SuiteSetting> written;
  std::vector<SuiteSetting> checked;
};

// The product of the axes; the last one varies fastest.
StatusOr<std::vector<GridPoint>> Points(const SuiteGrid& grid,
                                        SettingTaker* taker) {
  std::vector<GridPoint> points(1);
  for (const auto& [key, values] : grid.axes) {
    if (points.size() * values.size() > kMaxCells) {
      return InvalidArgumentError("[grid " + grid.name +
                                  "]: more than 10000 "
                                  "points");
    }
    std::vector<SuiteSetting> checked;
    for (const std::string& value : values) {
      FREEGS_ASSIGN_OR_RETURN(
          SuiteSetting setting,
          taker->Checked({key, value}, "[grid " + grid.name + "]"));
      checked.push_back(std::move(setting));
    }
    std::vector<GridPoint> product;
    for (const GridPoint& point : points) {
      for (size_t i = 0; i < values.size(); ++i) {
        product.push_back(point);
        product.back().written.emplace_back(key, values[i]);
        product.back().checked.push_back(checked[i]);
      }
    }
    points = std::move(product);
  }
  return points;
}

const std::vector<int64_t>& Seeds(const Suite& suite, const SuiteGrid& grid) {
  return grid.seeds.empty() ? suite.seeds : grid.seeds;
}

std::string CellId(const std::string& scene, const SuiteCell& cell) {
  std::string id = scene + ", grid " + cell.grid;
  const char* separator = ": ";
  for (const auto& [key, value] : cell.point) {
    id += separator + key + "=" + value;
    separator = " ";
  }
  return id + ", seed " + std::to_string(cell.seed);
}

Status CheckLastStage(const Suite& suite) {
  const std::vector<std::string> stages = StageNames();
  if (std::find(stages.begin(), stages.end(), suite.to) != stages.end()) {
    return Status();
  }
  std::string names;
  for (const std::string& stage : stages) {
    names += (names.empty() ? "" : ", ") + stage;
  }
  return InvalidArgumentError(suite.name + ": [suite] to: there is no stage '" +
                              suite.to + "'; there are " + names);
}

}  // namespace

StatusOr<std::vector<SuiteCell>> MakeCells(const Suite& suite,
                                           const SuiteChecks& checks) {
  FREEGS_RETURN_IF_ERROR(CheckLastStage(suite));
  SettingTaker taker(suite, checks);
  FREEGS_ASSIGN_OR_RETURN(const std::vector<SuiteSetting> common,
                          taker.AllChecked(suite.settings, "[suite]"));
  std::vector<std::pair<const SuiteGrid*, GridPoint>> points;
  size_t num_cells = 0;
  for (const SuiteGrid& grid : suite.grids) {
    FREEGS_ASSIGN_OR_RETURN(std::vector<GridPoint> of_grid,
                            Points(grid, &taker));
    num_cells +=
        of_grid.size() * suite.scenes.size() * Seeds(suite, grid).size();
    if (num_cells > kMaxCells) {
      return InvalidArgumentError(suite.name + ": more than 10000 cells");
    }
    for (GridPoint& point : of_grid) {
      points.emplace_back(&grid, std::move(point));
    }
  }
  std::vector<SuiteCell> cells;
  for (size_t scene = 0; scene < suite.scenes.size(); ++scene) {
    const std::string& name = suite.scenes[scene].name;
    FREEGS_ASSIGN_OR_RETURN(
        const std::vector<SuiteSetting> of_scene,
        taker.AllChecked(suite.scenes[scene].settings, "[scene " + name + "]"));
    for (const auto& [grid, point] : points) {
      for (const int64_t seed : Seeds(suite, *grid)) {
        SuiteCell cell;
        cell.scene = scene;
        cell.grid = grid->name;
        cell.seed = seed;
        cell.point = point.written;
        AddSettings(common, &cell);
        AddSettings(of_scene, &cell);
        AddSettings(point.checked, &cell);
        cell.id = CellId(name, cell);
        cells.push_back(std::move(cell));
      }
    }
  }
  return cells;
}

std::vector<std::string> GridKeys(const Suite& suite) {
  std::vector<std::string> keys;
  for (const SuiteGrid& grid : suite.grids) {
    for (const auto& [key, values] : grid.axes) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) {
        keys.push_back(key);
      }
    }
  }
  return keys;
}

}  // namespace freegs::stages
