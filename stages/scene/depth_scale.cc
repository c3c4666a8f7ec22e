// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/depth_scale.h"

#include <algorithm>
#include <set>
#include <system_error>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_fields.h"
#include "core/io/json_text.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// The pictures that the depth.json of an earlier call lists and that are still
// there. Nothing where it lists none, as those of older programs.
std::vector<std::string> PicturesOf(const json& scale, const fs::path& folder) {
  std::vector<std::string> pictures;
  const json* listed = FindField(scale, "pictures");
  if (listed == nullptr || !listed->is_array()) return pictures;
  for (const json& name : *listed) {
    std::error_code error;
    if (name.is_string() &&
        fs::exists(folder / name.get<std::string>(), error)) {
      pictures.push_back(name.get<std::string>());
    }
  }
  return pictures;
}

}  // namespace

Status WriteDepthScale(const fs::path& folder,
                       double unit,
                       const DepthRange& range,
                       const std::vector<std::string>& names) {
  const fs::path file = folder / "depth.json";
  std::set<std::string> pictures(names.begin(), names.end());
  const StatusOr<json> before = ReadJson(file);
  if (before.ok() && before->is_object()) {
    const std::vector<std::string> old = PicturesOf(*before, folder);
    const json* old_unit = FindField(*before, "unit");
    if (old_unit != nullptr && *old_unit == unit) {
      pictures.insert(old.begin(), old.end());
    } else {
      const auto stays =
          std::ranges::find_if(old, [&](const std::string& picture) {
            return !pictures.contains(picture);
          });
      if (stays != old.end()) {
        return InvalidArgumentError(folder.string() +
                                    ": has depth with another unit, such as " +
                                    *stays + "; take another folder");
      }
      for (const std::string& picture : old) {
        std::error_code error;
        fs::remove(folder / picture, error);
      }
    }
  }
  const json scale = {{"unit", unit},
                      {"nothing", 0},
                      {"beyond", 65535},
                      {"near", range.near},
                      {"far", range.far},
                      {"pictures", pictures}};
  return WriteFileAtomic(file, JsonText(scale));
}

}  // namespace freegs::stages
