// SPDX-License-Identifier: BSD-3-Clause
// Stands in for COLMAP in tests: the same commands, options, output and files
// as release 3.8 or 4.x, without looking at a single pixel. Photo k sees the
// synthetic model from camera k.
//
// Told what to do by the environment:
//   FAKE_COLMAP_DIALECT  3 (default) or 4: names of options, style of output.
//   FAKE_COLMAP_MODELS   photos of each model the mapper makes, "5,3"; empty
//                        for none. Default: one of all.
//   FAKE_COLMAP_RELAXED  the same when the mapper's thresholds were lowered.
//   FAKE_COLMAP_SMALL    the same when it is to keep small models.
//   FAKE_COLMAP_PAIR     the same when it is told with which pair to begin.
//   FAKE_COLMAP_CONTINUED  folder of the model that the mapper makes when it is
//                        given one to go on from. Default: the one given.
//   FAKE_COLMAP_SENSELESS  the mapper ends with cameras that no photo has,
//                        unless its thresholds were lowered.
//   FAKE_COLMAP_OTHERS   how many photos are registered to a given model.
//                        Default: all others.
//   FAKE_COLMAP_POINTS   number of points that are triangulated. With none,
//                        release 3.8 aborts; 4.x writes a model without points.
//   FAKE_COLMAP_FAIL     a command that fails with exit code 1.
//   FAKE_COLMAP_SIGNAL   the number of a signal that ends it instead.
//   FAKE_COLMAP_HANG     a command that never ends.
//   FAKE_COLMAP_ONCE     a file: commands fail while it exists, and delete it.
//   FAKE_COLMAP_LENIENT  take any option; who starts it has checked them.
//   FAKE_COLMAP_KEEP     leave distortion in undistorted models.

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <sqlite3.h>
#include <sstream>
#include <string>
#include <unistd.h>
#include <vector>

#include "sfm/scene/model_io.h"
#include "tests/sfm/synthetic_model.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

std::string Setting(const char* name, const std::string& fallback = "") {
  const char* value = std::getenv(name);
  return value == nullptr ? fallback : value;
}

bool IsNew() { return Setting("FAKE_COLMAP_DIALECT", "3") == "4"; }

// Newer releases log with a prefix.
void Print(const std::string& text) {
  std::cout << (IsNew() ? "I20260101 12:00:00.000001 7 file.cc:9] " : "")
            << text << std::endl;
}

const std::map<std::string, std::vector<std::string>>& CommandOptions() {
  static const std::string features =
      IsNew() ? "FeatureExtraction." : "SiftExtraction.";
  static const std::string matching =
      IsNew() ? "FeatureMatching." : "SiftMatching.";
  static const std::map<std::string, std::vector<std::string>> options = {
      {"feature_extractor",
       {"database_path",
        "image_path",
        "image_list_path",
        "ImageReader.camera_model",
        "ImageReader.single_camera",
        "ImageReader.single_camera_per_image",
        features + "use_gpu",
        features + "num_threads"}},
      {"matches_importer",
       {"database_path",
        "match_list_path",
        "match_type",
        matching + "use_gpu",
        matching + "num_threads",
        matching + "guided_matching",
        IsNew() ? "default_random_seed" : "random_seed"}},
      {"mapper",
       {"database_path",
        "image_path",
        "image_list_path",
        "input_path",
        "output_path",
        "Mapper.num_threads",
        "Mapper.init_image_id1",
        "Mapper.init_image_id2",
        "Mapper.multiple_models",
        "Mapper.init_min_num_inliers",
        "Mapper.min_model_size",
        "Mapper.init_min_tri_angle",
        IsNew() ? "Mapper.random_seed" : "random_seed"}},
      {"image_registrator",
       {"database_path",
        "input_path",
        "output_path",
        "Mapper.num_threads",
        IsNew() ? "Mapper.random_seed" : "random_seed"}},
      {"point_triangulator",
       {"database_path",
        "image_path",
        "input_path",
        "output_path",
        "Mapper.num_threads",
        IsNew() ? "Mapper.random_seed" : "random_seed"}},
      {"image_undistorter",
       {"image_path",
        "input_path",
        "output_path",
        "output_type",
        "max_image_size"}},
  };
  return options;
}

void PrintHelp() {
  std::cout << "COLMAP " << (IsNew() ? "4.1.1" : "3.8")
            << " -- Structure-from-Motion and Multi-View Stereo\n"
            << "              (Commit abc on 2026 without CUDA)\n\nUsage:\n"
            << "  colmap [command] [options]\n\nAvailable commands:\n  help\n";
  for (const auto& entry : CommandOptions()) {
    std::cout << "  " << entry.first << "\n";
  }
}

void PrintCommandHelp(const std::string& command) {
  std::cout << "Options can be given -- see below.\n\n  -h [ --help ] \n";
  for (const std::string& option : CommandOptions().at(command)) {
    std::cout << "  --" << option << " arg (=1)\n";
  }
}

class Database {
 public:
  explicit Database(const std::string& path) {
    if (sqlite3_open(path.c_str(), &database_) != SQLITE_OK) std::exit(9);
    Run("PRAGMA synchronous = OFF");
    Run("CREATE TABLE IF NOT EXISTS images (image_id INTEGER PRIMARY KEY "
        "AUTOINCREMENT NOT NULL, name TEXT NOT NULL UNIQUE, "
        "camera_id INTEGER NOT NULL DEFAULT 1)");
    Run("CREATE TABLE IF NOT EXISTS cameras (camera_id INTEGER PRIMARY KEY, "
        "width INTEGER NOT NULL, height INTEGER NOT NULL, params BLOB, "
        "prior_focal_length INTEGER NOT NULL, model INTEGER NOT NULL)");
    Run("CREATE TABLE IF NOT EXISTS keypoints (image_id INTEGER PRIMARY KEY, "
        "rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB)");
    Run("CREATE TABLE IF NOT EXISTS descriptors (image_id INTEGER PRIMARY KEY, "
        "rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB)");
    Run("CREATE TABLE IF NOT EXISTS matches (pair_id INTEGER PRIMARY KEY, "
        "rows INTEGER NOT NULL, data BLOB)");
    Run("CREATE TABLE IF NOT EXISTS two_view_geometries (pair_id INTEGER "
        "PRIMARY KEY, rows INTEGER NOT NULL, data BLOB)");
  }
  ~Database() { sqlite3_close(database_); }

  void Run(const std::string& sql) {
    if (sqlite3_exec(database_, sql.c_str(), nullptr, nullptr, nullptr) !=
        SQLITE_OK) {
      std::cerr << sqlite3_errmsg(database_) << "\n";
      std::exit(9);
    }
  }

  std::map<std::string, int> Images() {
    std::map<std::string, int> images;
    sqlite3_exec(
        database_,
        "SELECT name, image_id FROM images",
        [](void* target, int, char** row, char**) {
          (*static_cast<std::map<std::string, int>*>(target))[row[0]] =
              std::atoi(row[1]);
          return 0;
        },
        &images,
        nullptr);
    return images;
  }

 private:
  sqlite3* database_ = nullptr;
};

// Descriptors, in hexadecimal, that are the same in all photos: feature k has
// its one large value at place k.
constexpr int kNumFeatures = 20;
std::string Descriptors() {
  std::string text;
  for (int k = 0; k < kNumFeatures; ++k) {
    for (int i = 0; i < 128; ++i) text += i == k ? "ff" : "00";
  }
  return text;
}

std::vector<std::string> ReadLines(const std::string& path) {
  std::vector<std::string> lines;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

using Options = std::map<std::string, std::string>;

int ExtractFeatures(Options& options) {
  Database database(options["database_path"]);
  const auto names = ReadLines(options["image_list_path"]);
  std::string camera;
  for (size_t i = 0; i < names.size(); ++i) {
    database.Run("INSERT OR IGNORE INTO images(name) VALUES('" + names[i] +
                 "')");
    const std::string id = std::to_string(database.Images().at(names[i]));
    // Each photo has a camera of its own, or all of this call share one.
    if (i == 0 || options["ImageReader.single_camera_per_image"] == "1") {
      camera = id;
      database.Run("INSERT OR IGNORE INTO cameras VALUES(" + camera +
                   ",32,32,NULL,0,0)");
    }
    database.Run("UPDATE images SET camera_id = " + camera +
                 " WHERE image_id = " + id);
    const std::string count = std::to_string(kNumFeatures);
    database.Run("INSERT OR IGNORE INTO keypoints VALUES(" + id + "," + count +
                 ",4,zeroblob(" + std::to_string(16 * kNumFeatures) + "))");
    database.Run("INSERT OR IGNORE INTO descriptors VALUES(" + id + "," +
                 count + ",128,x'" + Descriptors() + "')");
    Print("Processed file [" + std::to_string(i + 1) + "/" +
          std::to_string(names.size()) + "]");
  }
  return 0;
}

std::string PairId(const std::map<std::string, int>& images,
                   const std::string& line) {
  std::istringstream words(line);
  std::string a, b;
  words >> a >> b;
  const int64_t first = std::min(images.at(a), images.at(b));
  const int64_t second = std::max(images.at(a), images.at(b));
  return std::to_string(first * 2147483647 + second);
}

int MatchPairs(Options& options) {
  Database database(options["database_path"]);
  const auto images = database.Images();
  if (options["match_type"] != "raw") return 9;
  // Blocks: two names, lines of two numbers, an empty line.
  std::string pair;
  int count = 0;
  for (const std::string& line : ReadLines(options["match_list_path"])) {
    if (pair.empty()) {
      pair = PairId(images, line);
      count = 0;
    } else if (!line.empty()) {
      ++count;
    } else {
      const std::string row = "(" + pair + "," + std::to_string(count) +
                              ",zeroblob(" + std::to_string(8 * count) + "))";
      database.Run("INSERT INTO matches VALUES" + row);
      database.Run("INSERT INTO two_view_geometries VALUES" + row);
      pair.clear();
    }
  }
  Print("Matching block [1/1] in 0.1s");
  return 0;
}

// A sanitizer would handle the signal otherwise.
void EndBySignal(int signal) {
  std::signal(signal, SIG_DFL);
  kill(getpid(), signal);
}

int ContinueMapping(Options& options) {
  const auto model =
      ReadModel(Setting("FAKE_COLMAP_CONTINUED", options["input_path"]));
  return model.ok() && WriteModel(options["output_path"], *model).ok() ? 0 : 9;
}

int Map(Options& options) {
  if (options["input_path"] != "") return ContinueMapping(options);
  Database database(options["database_path"]);
  auto images = database.Images();
  const auto num_photos = static_cast<int>(images.size());
  if (options["image_list_path"] != "") {
    const auto listed = ReadLines(options["image_list_path"]);
    std::erase_if(images, [&](const auto& image) {
      return std::find(listed.begin(), listed.end(), image.first) ==
             listed.end();
    });
  }
  std::string sizes =
      Setting("FAKE_COLMAP_MODELS", std::to_string(images.size()));
  if (options["Mapper.init_image_id1"] != "") {
    Print("Initializing with image pair #" + options["Mapper.init_image_id1"] +
          " and #" + options["Mapper.init_image_id2"]);
    sizes = Setting("FAKE_COLMAP_PAIR", sizes);
  } else if (options["Mapper.init_min_num_inliers"] != "") {
    sizes = Setting("FAKE_COLMAP_RELAXED", sizes);
  }
  if (options["Mapper.min_model_size"] != "") {
    sizes = Setting("FAKE_COLMAP_SMALL", sizes);
  }
  std::istringstream list(sizes);
  int number = 0;
  auto next = images.begin();
  for (std::string size; std::getline(list, size, ',');) {
    Reconstruction model = SyntheticModel(num_photos, 150 - number);
    Reconstruction kept = model;
    kept.images.clear();
    for (int i = 0; i < std::stoi(size) && next != images.end(); ++i, ++next) {
      PosedImage image = model.images[next->second - 1];
      image.name = next->first;
      Print("Registering image #" + std::to_string(next->second) +
            (IsNew() ? " (num_reg_frames=" : " (") + std::to_string(i + 1) +
            ")");
      kept.images.push_back(image);
    }
    RemoveDanglingReferences(&kept);
    if (Setting("FAKE_COLMAP_SENSELESS") != "" &&
        options["Mapper.init_min_num_inliers"] == "") {
      for (Camera& camera : kept.cameras) camera.params[0] = 1;
    }
    const fs::path folder =
        fs::path(options["output_path"]) / std::to_string(number++);
    if (!WriteModel(folder, kept).ok()) return 9;
  }
  if (number > 0) return 0;
  std::cerr << "ERROR: failed to create sparse model" << std::endl;
  return 1;
}

int RegisterOthers(Options& options) {
  auto model = ReadModel(options["input_path"]);
  if (!model.ok()) return 9;
  Database database(options["database_path"]);
  const auto images = database.Images();
  int left =
      std::stoi(Setting("FAKE_COLMAP_OTHERS", std::to_string(images.size())));
  const Reconstruction all = SyntheticModel(static_cast<int>(images.size()), 0);
  for (const auto& [name, id] : images) {
    const auto has = [&, id = id](const PosedImage& image) {
      return static_cast<int>(image.id) == id;
    };
    if (left == 0 ||
        std::any_of(model->images.begin(), model->images.end(), has)) {
      continue;
    }
    --left;
    model->images.push_back(all.images[id - 1]);
    model->images.back().name = name;
    Print("Registering image #" + std::to_string(id) +
          (IsNew() ? " (num_reg_frames=" : " (") +
          std::to_string(model->images.size()) + ")");
  }
  return WriteModel(options["output_path"], *model).ok() ? 0 : 9;
}

// Features and points are those of the synthetic model, whatever the poses.
int Triangulate(Options& options) {
  auto model = ReadModel(options["input_path"]);
  if (!model.ok()) return 9;
  const int points = std::stoi(Setting("FAKE_COLMAP_POINTS", "150"));
  if (points == 0 && !IsNew()) {
    std::cerr << "Check failed: bundle_adjuster.Solve(&reconstruction)"
              << std::endl;
    EndBySignal(SIGABRT);
  }
  const size_t num_photos = Database(options["database_path"]).Images().size();
  const Reconstruction seen =
      SyntheticModel(static_cast<int>(num_photos), points);
  for (PosedImage& image : model->images) {
    if (!image.points2d.empty() || image.id < 1 || image.id > num_photos) {
      return 9;
    }
    image.points2d = seen.images[image.id - 1].points2d;
  }
  model->points3d = seen.points3d;
  RemoveDanglingReferences(&*model);
  for (Point3D& point : model->points3d) point.rgb = {0, 0, 0};
  return WriteModel(options["output_path"], *model).ok() ? 0 : 9;
}

int UndistortImages(Options& options) {
  auto model = ReadModel(options["input_path"]);
  if (!model.ok()) return 9;
  const fs::path output = options["output_path"];
  for (const PosedImage& image : model->images) {
    const fs::path to = output / "images" / image.name;
    fs::create_directories(to.parent_path());
    fs::copy_file(fs::path(options["image_path"]) / image.name, to);
    Print("Undistorting image [1/" + std::to_string(model->images.size()) +
          "]");
  }
  for (Camera& camera : model->cameras) {
    if (Setting("FAKE_COLMAP_KEEP") != "") break;
    camera.params = {camera.FocalX(),
                     camera.FocalY(),
                     camera.PrincipalX(),
                     camera.PrincipalY()};
    camera.model = CameraModel::kPinhole;
  }
  return WriteModel(output / "sparse", *model).ok() ? 0 : 9;
}

int Run(int argc, char** argv) {
  const std::string command = argc > 1 ? argv[1] : "help";
  if (command == "help") {
    PrintHelp();
    return 0;
  }
  const auto known = CommandOptions().find(command);
  if (known == CommandOptions().end()) {
    std::cerr << "ERROR: Command " << command << " not recognized.\n";
    return 1;
  }
  Options options;
  for (int i = 2; i < argc; i += 2) {
    const std::string name = std::string(argv[i]).substr(2);
    if (name == "help") {
      PrintCommandHelp(command);
      return 0;
    }
    const bool lenient = !Setting("FAKE_COLMAP_LENIENT").empty();
    if ((!lenient &&
         std::find(known->second.begin(), known->second.end(), name) ==
             known->second.end()) ||
        i + 1 >= argc) {
      std::cerr << "ERROR: unrecognised option '--" << name << "'\n";
      return 1;
    }
    if (options.contains(name)) {
      std::cerr << "ERROR: option '--" << name << "' more than once\n";
      return 1;
    }
    options[name] = argv[i + 1];
  }
  if (Setting("QT_QPA_PLATFORM") != "offscreen") {
    std::cerr << "could not connect to display" << std::endl;
    std::abort();
  }
  if (Setting("FAKE_COLMAP_HANG") == command) {
    Print("hanging");
    sleep(1000);
  }
  const std::string once = Setting("FAKE_COLMAP_ONCE");
  if (Setting("FAKE_COLMAP_FAIL") == command &&
      (once.empty() || fs::remove(once))) {
    std::cerr << "something went wrong" << std::endl;
    const std::string signal = Setting("FAKE_COLMAP_SIGNAL");
    if (!signal.empty()) EndBySignal(std::stoi(signal));
    return 1;
  }
  if (command == "feature_extractor") return ExtractFeatures(options);
  if (command == "matches_importer") return MatchPairs(options);
  if (command == "mapper") return Map(options);
  if (command == "image_registrator") return RegisterOthers(options);
  if (command == "point_triangulator") return Triangulate(options);
  return UndistortImages(options);
}

}  // namespace
}  // namespace freegs::sfm

int main(int argc, char** argv) { return freegs::sfm::Run(argc, argv); }
