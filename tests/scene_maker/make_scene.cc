// SPDX-License-Identifier: BSD-3-Clause
// freegs_make_scene: writes a made-up scene with its truth.

#include <cstdio>
#include <iostream>
#include <string>

#include <boost/program_options.hpp>

#include "core/parallel.h"
#include "tests/scene_maker/scene.h"
#include "tests/scene_maker/scene_files.h"

namespace {

namespace po = boost::program_options;
using freegs::scene_maker::Motion;
using freegs::scene_maker::Subject;

int Fail(const std::string& message) {
  std::cerr << "freegs_make_scene: " << message << "\n";
  return 2;
}

int Run(int argc, char** argv) {
  freegs::scene_maker::SceneMakerOptions options;
  std::string folder;
  std::string texture;
  std::string motion;
  std::string subject;
  int threads = 0;
  po::options_description description("Draws a made-up scene. Options");
  // clang-format off
  description.add_options()
      ("help,h", "this text")
      ("out", po::value(&folder)->required(), "empty or new folder to write")
      ("views", po::value(&options.views)->default_value(options.views),
       "photographs to reconstruct from")
      ("test_views",
       po::value(&options.test_views)->default_value(options.test_views),
       "photographs for evaluation")
      ("width", po::value(&options.width)->default_value(options.width),
       "pixels")
      ("height", po::value(&options.height)->default_value(options.height),
       "pixels")
      ("seed", po::value(&options.seed)->default_value(options.seed),
       "decides placement, textures and the camera's shake")
      ("objects", po::value(&options.objects)->default_value(options.objects),
       "objects on the table, or pieces of furniture, 1 to 12")
      ("scene", po::value(&subject)->default_value("table"),
       "table; clutter: random things; furniture; chairs: two equal ones; "
       "tiles: a wall of equal ones; studio: objects in front of white")
      ("arc", po::value(&options.arc)->default_value(options.arc),
       "degrees that the photographs cover; 0: as many as there are photos")
      ("texture", po::value(&texture)->default_value("rich"), "rich or none")
      ("motion", po::value(&motion)->default_value("orbit"),
       "orbit, or rotation: turning on the spot")
      ("threads", po::value(&threads)->default_value(0), "0: all cores");
  // clang-format on
  po::variables_map values;
  try {
    po::store(po::parse_command_line(argc, argv, description), values);
    if (values.count("help") != 0) {
      std::cout << description;
      return 0;
    }
    po::notify(values);
  } catch (const po::error& error) {
    return Fail(error.what());
  }
  if (texture != "rich" && texture != "none") {
    return Fail("--texture is rich or none");
  }
  if (motion != "orbit" && motion != "rotation") {
    return Fail("--motion is orbit or rotation");
  }
  if (subject == "chairs") {
    options.subject = Subject::kChairs;
  } else if (subject == "tiles") {
    options.subject = Subject::kTiles;
  } else if (subject == "clutter") {
    options.subject = Subject::kClutter;
  } else if (subject == "furniture") {
    options.subject = Subject::kFurniture;
  } else if (subject == "studio") {
    options.subject = Subject::kStudio;
  } else if (subject != "table") {
    return Fail(
        "--scene is table, clutter, furniture, chairs, tiles or studio");
  }
  options.textured = texture == "rich";
  options.motion = motion == "orbit" ? Motion::kOrbit : Motion::kRotation;

  const auto scene = freegs::scene_maker::BuildScene(options);
  if (!scene.ok()) return Fail(scene.status().message());
  freegs::ThreadPool pool(threads);
  const freegs::Status status = freegs::scene_maker::WriteScene(
      *scene, folder, pool, [](int done, int total) {
        std::fprintf(stderr, "\rphotograph %d of %d ", done, total);
      });
  std::fprintf(stderr, "\n");
  if (!status.ok()) {
    std::cerr << "freegs_make_scene: " << status.message() << "\n";
    return 1;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return Run(argc, argv); }
