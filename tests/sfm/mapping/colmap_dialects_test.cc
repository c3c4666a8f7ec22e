// SPDX-License-Identifier: BSD-3-Clause
// Structure from motion with the option names of each release of COLMAP.
// colmap_dialects/VERSION.txt lists a release's commands, and below each
// command that we may use, its options.

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sfm/colmap/colmap_program.h"
#include "sfm/mapping/structure_from_motion.h"
#include "tests/sfm/fake_colmap.h"
#include "tests/sfm/synthetic_model.h"
#include "tests/sfm/textured_photo.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::Pair;
using testing::SizeIs;

using Arguments = std::map<std::string, std::string>;

// One call of the program.
struct Call {
  std::string command;
  Arguments arguments;
};

fs::path DialectFile(const std::string& release) {
  return fs::path(FREEGS_COLMAP_DIALECTS) / (release + ".txt");
}

// Answers help as the release does, records its arguments one per line, refuses
// options that the release does not have, and leaves the work to the fake
// COLMAP.
constexpr char kScript[] = R"sh(#!/bin/sh
options() {
  awk -v command="$1" '/^[^ ]/ { on = $1 == command; next } on { print $1 }' \
    "$LIST"
}
case "$1" in
  help|-h|--help|'')
    echo "COLMAP $RELEASE$BUILD"
    echo "Available commands:"
    echo "  help"
    awk '/^[^ #]/ { print "  " $1 }' "$LIST"
    exit 0 ;;
esac
if ! grep -qx "$1" "$LIST"; then
  echo "ERROR: Command $1 not recognized." >&2
  exit 1
fi
if [ "$2" = --help ]; then
  echo "${PREFIX}Options can either be specified via command-line or ..." >&2
  echo "  -h [ --help ] " >&2
  options "$1" | grep -vx help | sed 's/.*/  --& arg (=-1)/' >&2
  exit 0
fi
# A file per call: several run at once.
{ echo "COMMAND $1"; printf '%s\n' "$@"; } \
  > "$RECORD/$(date +%s%N)_$$"
known=" $(options "$1" | tr '\n' ' ') "
for argument in "$@";
do
  case "$argument" in
    --*)
      case "$known" in
        *" ${argument#--} "*) ;;
        *) echo "ERROR: unrecognised option '$argument'" >&2; exit 1 ;;
      esac ;;
  esac
done
exec "$FAKE" "$@"
)sh";

class ColmapDialectsTest : public testing::Test {
 protected:
  // A program that speaks the dialect of `list` and calls itself `release`.
  std::string MakeProgram(const std::string& release, const fs::path& list) {
    const bool new_style = release[0] != '3';
    record_ = folder_ / "record";
    fs::remove_all(record_);
    fs::create_directory(record_);
    std::string script = kScript;
    const std::string first_line = "#!/bin/sh\n";
    std::string settings = "export FAKE_COLMAP_LENIENT=1\n";
    settings +=
        "export FAKE_COLMAP_DIALECT=" + std::string(new_style ? "4" : "3") +
        "\n";
    settings += "LIST='" + list.string() + "'\nRELEASE='" + release + "'\n";
    settings += "BUILD='" +
                std::string(new_style ? " (Commit abc on 2026 without CUDA)"
                                      : " -- Structure-from-Motion") +
                "'\n";
    settings += "PREFIX='" +
                std::string(release.starts_with("3.8")
                                ? ""
                                : "I20260101 12:00:00.000001 7 file.cc:9] ") +
                "'\n";
    settings += "RECORD='" + record_.string() + "'\n";
    settings += "FAKE='" FREEGS_FAKE_COLMAP "'\n";
    script.insert(first_line.size(), settings);
    const fs::path path = folder_ / "colmap";
    WriteText(path, script);
    fs::permissions(path, fs::perms::owner_all);
    return path.string();
  }

  // Structure from motion of eight photos; what the program was asked.
  StatusOr<SfmResult> Run(const std::string& release, const fs::path& list) {
    SfmInput input;
    input.photo_folder = folder_ / "photos";
    input.work_folder = folder_ / "work folder";
    input.seed = 5;
    fs::remove_all(input.work_folder);
    for (int i = 0; i < 8; ++i) {
      SfmPhoto photo;
      photo.name = PhotoName(i);
      photo.width = 640;
      photo.height = 480;
      photo.focal_px = 600;
      input.photos.push_back(photo);
    }
    WriteTexturedPhotos(input);
    SfmOptions options;
    options.num_threads = 2;
    options.colmap = MakeProgram(release, list);
    StatusOr<SfmResult> result = RunStructureFromMotion(input, options);
    ReadRecord();
    return result;
  }

  void ReadRecord() {
    calls_.clear();
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(record_)) {
      files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) ReadCall(file);
  }

  void ReadCall(const fs::path& path) {
    std::ifstream file(path);
    std::string option;
    for (std::string line; std::getline(file, line);) {
      if (line.starts_with("COMMAND ")) {
        calls_.push_back({line.substr(8), {}});
      } else if (line.starts_with("--")) {
        option = line.substr(2);
      } else if (!option.empty()) {
        calls_.back().arguments[option] = line;
        option.clear();
      }
    }
  }

  std::vector<Arguments> Calls(const std::string& command) const {
    std::vector<Arguments> found;
    for (const Call& call : calls_) {
      if (call.command == command) found.push_back(call.arguments);
    }
    return found;
  }

  // What every release must be told, under its own names.
  void ExpectComplete(const std::string& extraction,
                      const std::string& matching,
                      const std::vector<std::string>& match_seeds,
                      const std::vector<std::string>& mapper_seeds,
                      const std::string& frames_ratio) const {
    const std::vector<Arguments> features = Calls("feature_extractor");
    ASSERT_THAT(features, SizeIs(1));
    EXPECT_THAT(features[0],
                AllOf(Contains(Pair(extraction + ".use_gpu", "0")),
                      Contains(Pair("ImageReader.camera_model", "RADIAL")),
                      Contains(Pair("ImageReader.single_camera", "1")),
                      Contains(Pair(extraction + ".num_threads", "1"))));
    const std::vector<Arguments> matches = Calls("matches_importer");
    ASSERT_FALSE(matches.empty());
    for (const Arguments& call : matches) {
      EXPECT_THAT(call,
                  AllOf(Contains(Pair(matching + ".use_gpu", "0")),
                        Contains(Pair(matching + ".num_threads", "1")),
                        Contains(Pair(HasSubstr(".max_num_trials"), "1000")),
                        Contains(Pair("match_type", "raw"))));
      for (const std::string& seed : match_seeds) {
        EXPECT_THAT(call, Contains(Pair(seed, "5")));
      }
    }
    const std::vector<Arguments> maps = Calls("mapper");
    ASSERT_FALSE(maps.empty());
    for (const std::string& seed : mapper_seeds) {
      EXPECT_THAT(maps[0], Contains(Pair(seed, "5")));
    }
    EXPECT_THAT(maps[0],
                AllOf(Contains(Pair("Mapper.num_threads", "1")),
                      Contains(Pair(frames_ratio, "1.3")),
                      Contains(Pair("Mapper.ba_global_points_ratio", "1.3")),
                      Contains(Pair("Mapper.ba_global_max_refinements", "1")),
                      Contains(Pair("Mapper.extract_colors", "0"))));
  }

  // Positions in photos (GPS) are never asked for.
  void ExpectNoPositions() const {
    for (const Call& call : calls_) {
      for (const char* word : {"prior", "gps", "spatial", "align"}) {
        EXPECT_THAT(call.command, Not(HasSubstr(word)));
        for (const auto& [option, value] : call.arguments) {
          EXPECT_THAT(option, Not(HasSubstr(word))) << call.command;
        }
      }
    }
  }

  TemporaryFolder folder_;
  fs::path record_;
  std::vector<Call> calls_;
};

TEST_F(ColmapDialectsTest, OldNames) {
  for (const char* release : {"3.8", "3.9", "3.11"}) {
    SCOPED_TRACE(release);
    const auto result = Run(release, DialectFile(release));
    ASSERT_TRUE(result.ok()) << result.status().message();
    EXPECT_EQ(result->colmap_version, release);
    EXPECT_EQ(result->models.at(0).images.size(), 8u);
    EXPECT_THAT(result->warnings, IsEmpty());
    ExpectComplete("SiftExtraction",
                   "SiftMatching",
                   {"random_seed"},
                   {"random_seed"},
                   "Mapper.ba_global_images_ratio");
    ExpectNoPositions();
  }
}

TEST_F(ColmapDialectsTest, NewNames) {
  const struct {
    const char* list;
    const char* release;
    size_t warnings;
  } cases[] = {{"3.13", "3.13.0", 0},
               {"4.0", "4.0.4", 2},
               {"4.1", "4.1.0", 2},
               {"4.1", "4.1.1", 0}};
  for (const auto& test : cases) {
    SCOPED_TRACE(test.release);
    const auto result = Run(test.release, DialectFile(test.list));
    ASSERT_TRUE(result.ok()) << result.status().message();
    EXPECT_EQ(result->colmap_version, test.release);
    EXPECT_EQ(result->models.at(0).images.size(), 8u);
    EXPECT_THAT(result->warnings, SizeIs(test.warnings));
    ExpectComplete("FeatureExtraction",
                   "FeatureMatching",
                   {"default_random_seed", "TwoViewGeometry.random_seed"},
                   {"default_random_seed", "Mapper.random_seed"},
                   "Mapper.ba_global_frames_ratio");
    ExpectNoPositions();
  }
}

// A release that nobody has seen yet: new options come, and some go.
TEST_F(ColmapDialectsTest, FutureReleaseIsAsked) {
  std::ifstream known(DialectFile("4.1"));
  std::string list;
  for (std::string line; std::getline(known, line);) {
    if (line == "  TwoViewGeometry.random_seed" ||
        line == "  Mapper.ba_global_frames_ratio") {
      continue;
    }
    list += line + "\n";
    if (line == "mapper") {
      list += "  Mapper.ba_global_images_ratio\n  Dream.depth\n";
    }
  }
  WriteText(folder_ / "future.txt", list);
  const auto result = Run("9.0.1.dev2", folder_ / "future.txt");
  ASSERT_TRUE(result.ok()) << result.status().message();
  EXPECT_EQ(result->colmap_version, "9.0.1.dev2");
  EXPECT_THAT(result->warnings, IsEmpty());
  EXPECT_THAT(Calls("mapper").at(0),
              Contains(Pair("Mapper.ba_global_images_ratio", "1.3")));
  ExpectNoPositions();
}

// Without an option that cannot be done without, it says which.
TEST_F(ColmapDialectsTest, MissingOptionIsNamed) {
  std::ifstream known(DialectFile("4.1"));
  std::string list;
  for (std::string line; std::getline(known, line);) {
    if (line != "  image_list_path") list += line + "\n";
  }
  WriteText(folder_ / "odd.txt", list);
  const auto result = Run("9.1", folder_ / "odd.txt");
  EXPECT_EQ(result.status().code(), StatusCode::kMissingDependency);
  EXPECT_THAT(result.status().message(), HasSubstr("--image_list_path"));
}

TEST_F(ColmapDialectsTest, KnownFaults) {
  const struct {
    const char* release;
    size_t faults;
  } cases[] = {{"3.7", 1},
               {"3.8", 0},
               {"3.10", 0},
               {"3.13.0", 0},
               {"4.0", 2},
               {"4.0.0", 2},
               {"4.1.0", 2},
               {"4.1.0-dev", 2},
               {"4.1.1", 0},
               {"4.2", 0},
               {"5", 0},
               {"99999999999999999999.1", 0}};
  for (const auto& test : cases) {
    const auto colmap = ColmapProgram::Find(
        MakeProgram(test.release, DialectFile("3.8")), nullptr);
    ASSERT_TRUE(colmap.ok()) << colmap.status().message();
    EXPECT_EQ(colmap->version(), test.release);
    EXPECT_THAT(colmap->KnownFaults(), SizeIs(test.faults)) << test.release;
  }
}

}  // namespace
}  // namespace freegs::sfm
