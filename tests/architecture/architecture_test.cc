// SPDX-License-Identifier: BSD-3-Clause
// The source tree keeps to the table of rooms in docs/architecture.md: no file
// and no room includes another in a circle, every arrow is in the table, and
// the table has no arrow that is not there. The diagram above it shows every
// room.

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/files.h"
#include "tests/architecture/include_graph.h"

namespace freegs::architecture {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

// More files than this in one folder are hard to take in. A .cc and its .h are
// one.
constexpr int kMaxFilesPerRoom = 18;

std::string Joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) {
    text += (text.empty() ? "" : " -> ") + name;
  }
  return text;
}

// The rooms that the diagram of the page shows: a word "query" within the
// subgraph "stages" is the room stages/query.
std::set<std::string> RoomsOfDiagram(std::string_view page) {
  std::set<std::string> rooms;
  std::string collection;
  bool inside = false;
  std::istringstream lines{std::string(page)};
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```")) inside = line == "```mermaid";
    if (!inside) continue;
    for (char& c : line) {
      const bool of_name = std::isalpha(static_cast<unsigned char>(c)) != 0 ||
                           c == '_' || c == '/';
      if (!of_name) c = ' ';
    }
    std::istringstream words(line);
    std::string word;
    if (line.starts_with("  subgraph ")) {
      words >> word >> word;
      collection = word + "/";
    } else if (line == "  end") {
      collection.clear();
    } else {
      while (words >> word) rooms.insert(collection + word);
    }
  }
  return rooms;
}

class ArchitectureTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const fs::path root = FREEGS_SOURCE_DIR;
    const StatusOr<std::string> page =
        ReadFile(root / "docs" / "architecture.md", uint64_t{1} << 24);
    ASSERT_TRUE(page.ok()) << page.status().message();
    drawn_ = RoomsOfDiagram(*page);
    StatusOr<std::vector<Room>> rooms = ParseRooms(*page);
    ASSERT_TRUE(rooms.ok()) << rooms.status().message();
    rooms_ = *std::move(rooms);
    std::set<std::string> folders;
    for (const Room& room : rooms_) {
      names_.insert(room.name);
      folders.insert(room.name.substr(0, room.name.find('/')));
    }
    StatusOr<Graph> files =
        ReadIncludeGraph(root, {folders.begin(), folders.end()});
    ASSERT_TRUE(files.ok()) << files.status().message();
    files_ = *std::move(files);
  }

  std::string RoomOfFile(const std::string& file) const {
    return RoomOf(file, names_);
  }

  std::vector<Room> rooms_;  // In the order of the table.
  std::set<std::string> names_;
  std::set<std::string> drawn_;  // The rooms of the diagram.
  Graph files_;
};

TEST_F(ArchitectureTest, TheDiagramShowsEveryRoom) {
  for (const std::string& name : names_) {
    EXPECT_TRUE(drawn_.contains(name))
        << "the diagram of docs/architecture.md does not show " << name;
  }
}

TEST_F(ArchitectureTest, NoFilesIncludeOneAnotherInACircle) {
  const std::vector<std::string> circle = FindCircle(files_);
  EXPECT_THAT(circle, IsEmpty()) << Joined(circle);
}

TEST_F(ArchitectureTest, EveryRoomIncludesOnlyRoomsOfLinesAboveItsOwn) {
  std::set<std::string> above;
  for (const Room& room : rooms_) {
    for (const std::string& included : room.includes) {
      EXPECT_TRUE(above.contains(included))
          << room.name << " includes " << included
          << ", which has no line above it";
    }
    above.insert(room.name);
  }
}

TEST_F(ArchitectureTest, EveryFileLiesInARoomOfTheTable) {
  std::map<std::string, int> sizes;
  for (const auto& [file, arrows] : files_) ++sizes[RoomOfFile(file)];
  for (const auto& [room, size] : sizes) {
    EXPECT_TRUE(names_.contains(room)) << room;
    EXPECT_LE(size, kMaxFilesPerRoom) << room;
  }
  for (const std::string& name : names_) {
    EXPECT_TRUE(sizes.contains(name)) << name << " has no files";
  }
}

TEST_F(ArchitectureTest, TheArrowsAreThoseOfTheTable) {
  Graph found;
  for (const auto& [file, arrows] : files_) {
    const std::string room = RoomOfFile(file);
    for (const std::string& target : arrows) {
      const std::string other = RoomOfFile(target);
      if (other == room) continue;
      found[room].insert(other);
      const auto line = std::find_if(
          rooms_.begin(), rooms_.end(), [&room](const Room& candidate) {
            return candidate.name == room;
          });
      EXPECT_TRUE(line != rooms_.end() && line->includes.contains(other))
          << file << " includes " << target << ", but the table has no arrow "
          << room << " -> " << other;
    }
  }
  for (const Room& room : rooms_) {
    for (const std::string& included : room.includes) {
      EXPECT_TRUE(found[room.name].contains(included))
          << "no file of " << room.name << " includes " << included
          << " any more: delete the arrow from the table";
    }
  }
}

// The one reader of JSON limits the depth. Files come from anywhere, and code
// that frees a document calls itself once per level.
TEST_F(ArchitectureTest, JsonIsParsedInOnePlace) {
  for (const auto& [file, arrows] : files_) {
    for (const char* suffix : {".cc", ".h"}) {
      const fs::path path = fs::path(FREEGS_SOURCE_DIR) / (file + suffix);
      if (!fs::exists(path) || file == "core/io/json_fields") continue;
      const StatusOr<std::string> text = ReadFile(path, uint64_t{1} << 24);
      ASSERT_TRUE(text.ok()) << text.status().message();
      EXPECT_EQ(text->find("json::parse("), std::string::npos)
          << path << ": call ParseJson of core/io/json_fields.h";
    }
  }
}

// The library of a room links what its files include, and nothing else of ours.
TEST_F(ArchitectureTest, LibrariesLinkWhatTheTableSays) {
  const auto target = [](const std::string& room) {
    std::string name = room == "pipeline" ? "runner" : room;
    std::replace(name.begin(), name.end(), '/', '_');
    return "freegs::" + name;
  };
  for (const Room& room : rooms_) {
    const fs::path file =
        fs::path(FREEGS_SOURCE_DIR) / room.name / "CMakeLists.txt";
    if (!fs::exists(file)) continue;  // The main program is no library.
    const StatusOr<std::string> text = ReadFile(file, uint64_t{1} << 20);
    ASSERT_TRUE(text.ok()) << text.status().message();
    std::string list = text->substr(text->find("freegs_add_library("));
    list = list.substr(0, list.find(')'));
    std::set<std::string> linked;
    std::istringstream words(list);
    for (std::string word; words >> word;) {
      if (word.starts_with("freegs::")) linked.insert(word);
    }
    std::set<std::string> wanted;
    for (const std::string& included : room.includes) {
      wanted.insert(target(included));
    }
    EXPECT_EQ(linked, wanted) << file;
  }
}

TEST(ParseRooms, ReadsBracesAndLinesThatGoOn) {
  const auto rooms =
      ParseRooms("text\n```rooms\na:\nb: a\nc/d: a\n  e/{f,g}\n```\nx: y\n");
  ASSERT_TRUE(rooms.ok()) << rooms.status().message();
  ASSERT_EQ(rooms->size(), 3u);
  EXPECT_EQ((*rooms)[0].name, "a");
  EXPECT_THAT((*rooms)[0].includes, IsEmpty());
  EXPECT_EQ((*rooms)[2].name, "c/d");
  EXPECT_THAT((*rooms)[2].includes, ElementsAre("a", "e/f", "e/g"));
}

TEST(ParseRooms, RefusesWhatIsNoTable) {
  EXPECT_FALSE(ParseRooms("").ok());
  EXPECT_FALSE(ParseRooms("```rooms\na:\n").ok());
  EXPECT_FALSE(ParseRooms("```rooms\nno colon\n```\n").ok());
  EXPECT_FALSE(ParseRooms("```rooms\na:\na:\n```\n").ok());
  EXPECT_FALSE(ParseRooms("```rooms\n  a\n```\n").ok());
}

TEST(FindCircle, NamesTheFilesAlongIt) {
  EXPECT_THAT(FindCircle({{"a", {"b", "c"}}, {"b", {"c"}}, {"c", {}}}),
              IsEmpty());
  EXPECT_THAT(FindCircle({{"a", {"b"}}, {"b", {"c"}}, {"c", {"d", "b"}}}),
              ElementsAre("b", "c", "b"));
}

TEST(Includes, TakesQuotedNamesOnly) {
  EXPECT_THAT(Includes("#include <map>\n#include \"core/a.h\"\n"
                       "#define HWY_TARGET_INCLUDE \"splat/b.cc\"\n"
                       "// #include \"core/c.h\"\n"),
              ElementsAre("core/a.h", "splat/b.cc"));
}

}  // namespace
}  // namespace freegs::architecture
