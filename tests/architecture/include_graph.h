// SPDX-License-Identifier: BSD-3-Clause
// Which source file includes which, and which room may include which.

#ifndef FREEGS_TESTS_ARCHITECTURE_INCLUDE_GRAPH_H_
#define FREEGS_TESTS_ARCHITECTURE_INCLUDE_GRAPH_H_

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"

namespace freegs::architecture {

// A directed graph by names: from each node to those it points to.
using Graph = std::map<std::string, std::set<std::string>>;

// One line of the table of rooms.
struct Room {
  std::string name;                // A folder such as "sfm/scene".
  std::set<std::string> includes;  // The rooms that it includes.
};

// Reads the table: the block of lines between "```rooms" and "```". A line is
//   NAME: ROOM ROOM ...
// where ROOM may be FOLDER/{A,B} for FOLDER/A and FOLDER/B; it goes on in the
// lines after it that begin with a space. kBadInput for a line without a colon,
// a room named twice, or a document without a table.
StatusOr<std::vector<Room>> ParseRooms(std::string_view document);

// The names in quotes of a file's #include lines, and of HWY_TARGET_INCLUDE,
// which is how Highway names the file that it includes several times.
std::vector<std::string> Includes(std::string_view source);

// The files below `folders` of `root`, each named by its path without suffix,
// so that a .cc and its .h are one node; with arrows to the files they include.
// An include that is no file below `root` is left out.
StatusOr<Graph> ReadIncludeGraph(const std::filesystem::path& root,
                                 const std::vector<std::string>& folders);

// The room of a file: its folder; or the file itself when `rooms` has it, as
// for the main program.
std::string RoomOf(const std::string& file, const std::set<std::string>& rooms);

// One circle of the graph as the names along it, the first repeated at the end;
// empty when there is none.
std::vector<std::string> FindCircle(const Graph& graph);

}  // namespace freegs::architecture

#endif  // FREEGS_TESTS_ARCHITECTURE_INCLUDE_GRAPH_H_
