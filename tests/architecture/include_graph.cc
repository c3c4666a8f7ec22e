// SPDX-License-Identifier: BSD-3-Clause

#include "tests/architecture/include_graph.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include "core/io/files.h"

namespace freegs::architecture {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxFileBytes = uint64_t{1} << 24;

// "a/{b,c}" is a/b and a/c.
std::vector<std::string> ExpandBraces(const std::string& text) {
  const size_t open = text.find('{');
  const size_t close = text.find('}');
  if (open == std::string::npos || close != text.size() - 1) return {text};
  std::vector<std::string> names;
  std::istringstream list(text.substr(open + 1, close - open - 1));
  for (std::string name; std::getline(list, name, ',');) {
    names.push_back(text.substr(0, open) + name);
  }
  return names;
}

// Follows arrows from `node`. `path` holds the nodes on the way to it; `done`
// those from which no circle can be reached.
bool FollowToCircle(const Graph& graph,
                    const std::string& node,
                    std::vector<std::string>* path,
                    std::set<std::string>* done) {
  if (done->contains(node)) return false;
  const auto before = std::find(path->begin(), path->end(), node);
  if (before != path->end()) {
    path->erase(path->begin(), before);
    path->push_back(node);
    return true;
  }
  path->push_back(node);
  const auto arrows = graph.find(node);
  if (arrows != graph.end()) {
    for (const std::string& next : arrows->second) {
      if (FollowToCircle(graph, next, path, done)) return true;
    }
  }
  path->pop_back();
  done->insert(node);
  return false;
}

std::string WithoutSuffix(const std::string& path) {
  return path.substr(0, path.rfind('.'));
}

bool IsSource(const fs::path& path) {
  return path.extension() == ".h" || path.extension() == ".cc";
}

}  // namespace

StatusOr<std::vector<Room>> ParseRooms(std::string_view document) {
  std::istringstream lines{std::string(document)};
  std::vector<Room> rooms;
  std::set<std::string> names;
  bool inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (!inside) {
      inside = line == "```rooms";
      continue;
    }
    if (line == "```") return rooms;
    if (line.empty()) continue;
    std::string list = line;
    if (line[0] != ' ') {
      const size_t colon = line.find(':');
      if (colon == std::string::npos) {
        return BadInputError("no colon in the line of rooms '" + line + "'");
      }
      rooms.push_back({line.substr(0, colon), {}});
      if (!names.insert(rooms.back().name).second) {
        return BadInputError("two lines for room " + rooms.back().name);
      }
      list = line.substr(colon + 1);
    }
    if (rooms.empty()) return BadInputError("a list without a room");
    std::istringstream words(list);
    for (std::string word; words >> word;) {
      for (std::string& name : ExpandBraces(word)) {
        rooms.back().includes.insert(std::move(name));
      }
    }
  }
  return BadInputError("there is no closed block of rooms");
}

std::vector<std::string> Includes(std::string_view source) {
  std::istringstream lines{std::string(source)};
  std::vector<std::string> names;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("#include \"") &&
        !line.starts_with("#define HWY_TARGET_INCLUDE \"")) {
      continue;
    }
    const size_t open = line.find('"');
    const size_t close = line.find('"', open + 1);
    if (close == std::string::npos) continue;
    names.push_back(line.substr(open + 1, close - open - 1));
  }
  return names;
}

StatusOr<Graph> ReadIncludeGraph(const fs::path& root,
                                 const std::vector<std::string>& folders) {
  Graph graph;
  for (const std::string& folder : folders) {
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      if (!entry.is_regular_file() || !IsSource(entry.path())) continue;
      FREEGS_ASSIGN_OR_RETURN(const std::string source,
                              ReadFile(entry.path(), kMaxFileBytes));
      const std::string file =
          WithoutSuffix(fs::relative(entry.path(), root).generic_string());
      std::set<std::string>& arrows = graph[file];
      for (const std::string& name : Includes(source)) {
        const std::string target = WithoutSuffix(name);
        if (target != file && fs::exists(root / name)) arrows.insert(target);
      }
    }
  }
  return graph;
}

std::string RoomOf(const std::string& file,
                   const std::set<std::string>& rooms) {
  if (rooms.contains(file)) return file;
  return fs::path(file).parent_path().generic_string();
}

std::vector<std::string> FindCircle(const Graph& graph) {
  std::set<std::string> done;
  for (const auto& [node, arrows] : graph) {
    std::vector<std::string> path;
    if (FollowToCircle(graph, node, &path, &done)) return path;
  }
  return {};
}

}  // namespace freegs::architecture
