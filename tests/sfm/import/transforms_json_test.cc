// SPDX-License-Identifier: BSD-3-Clause
// transforms.json: axes, intrinsics of all dialects, hostile files.

#include "sfm/import/transforms_json.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/number_text.h"
#include "core/random.h"

namespace freegs::sfm {
namespace {

using testing::HasSubstr;

constexpr char kValid[] = R"({
  "camera_angle_x": 0.7, "fl_x": 1000, "fl_y": 1001, "cx": 500.5, "cy": 300,
  "w": 1000, "h": 600, "k1": 0.05, "k2": -0.08, "p1": 0.001, "p2": 0.002,
  "frames": [
    {"file_path": "images/0001.jpg", "sharpness": 3,
     "transform_matrix": [[1,0,0,1],[0,0,-1,2],[0,1,0,3],[0,0,0,1]]},
    {"file_path": "images/0002.jpg", "fl_x": 900,
     "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,5]]}
  ]})";

TEST(ParseTransforms, AxesAreFlipped) {
  const auto file = ParseTransforms(kValid);
  ASSERT_TRUE(file.ok()) << file.status().message();
  ASSERT_EQ(file->frames.size(), 2u);
  // The camera looks along its -z, which in the first world is +y.
  const Rigid3d& pose = file->frames[0].cam_from_world;
  EXPECT_NEAR((CameraCentre(pose) - Eigen::Vector3d(1, 2, 3)).norm(), 0, 1e-12);
  const Eigen::Vector3d ahead = pose * Eigen::Vector3d(1, 2 + 5, 3);
  EXPECT_NEAR((ahead - Eigen::Vector3d(0, 0, 5)).norm(), 0, 1e-12);
  // World z is up; in the image that is -y.
  const Eigen::Vector3d above = pose * Eigen::Vector3d(1, 2 + 5, 3 + 1);
  EXPECT_NEAR((above - Eigen::Vector3d(0, -1, 5)).norm(), 0, 1e-12);
}

// Files of few digits have matrices that are a little longer than a rotation.
TEST(ParseTransforms, TheNearestRotationCounts) {
  const Eigen::Matrix3d rotation =
      Eigen::Quaterniond(0.2, -0.7, 0.4, 0.5).normalized().toRotationMatrix();
  const auto pose_of = [](const Eigen::Matrix3d& matrix) {
    std::string rows;
    for (int r = 0; r < 3; ++r) {
      rows += r == 0 ? "[" : ",[";
      for (int c = 0; c < 3; ++c)
        rows += FormatSignificant(matrix(r, c), 17) + ",";
      rows += "0]";
    }
    const auto file =
        ParseTransforms(R"({"fl_x": 100, "frames": [{"file_path": "a.png",)"
                        R"( "transform_matrix": [)" +
                        rows + "]}]}");
    EXPECT_TRUE(file.ok()) << file.status().message();
    return file.ok() ? file->frames[0].cam_from_world : Rigid3d();
  };
  const Rigid3d exact = pose_of(rotation);
  for (const double factor : {0.996, 1.004}) {
    const Rigid3d pose = pose_of(factor * rotation);
    EXPECT_LT(pose.rotation.angularDistance(exact.rotation), 1e-9) << factor;
    EXPECT_NEAR(pose.rotation.norm(), 1, 1e-12);
  }
}

TEST(MakeCamera, DistortionChoosesTheModel) {
  const auto file = ParseTransforms(kValid);
  ASSERT_TRUE(file.ok());
  const auto camera = MakeCamera(file->frames[0].intrinsics, 1000, 600);
  ASSERT_TRUE(camera.ok());
  EXPECT_EQ(camera->model, CameraModel::kOpenCv);
  EXPECT_EQ(
      camera->params,
      (std::vector<double>{1000, 1001, 500.5, 300, 0.05, -0.08, 0.001, 0.002}));
  // A frame's own value wins.
  const auto other = MakeCamera(file->frames[1].intrinsics, 1000, 600);
  EXPECT_EQ(other->FocalX(), 900);
  EXPECT_EQ(other->FocalY(), 900);

  TransformsIntrinsics in;
  in.fx = 100;
  EXPECT_EQ(MakeCamera(in, 64, 48)->model, CameraModel::kPinhole);
  in.k3 = 0.1;
  EXPECT_EQ(MakeCamera(in, 64, 48)->model, CameraModel::kFullOpenCv);
  in.fisheye = true;
  in.k4 = 0.2;
  EXPECT_EQ(MakeCamera(in, 64, 48)->model, CameraModel::kOpenCvFisheye);
  in.fisheye = false;
  EXPECT_FALSE(MakeCamera(in, 64, 48).ok());
}

TEST(MakeCamera, NoDistortionIsDroppedSilently) {
  for (double TransformsIntrinsics::*term : {&TransformsIntrinsics::p1,
                                             &TransformsIntrinsics::p2,
                                             &TransformsIntrinsics::k5,
                                             &TransformsIntrinsics::k6}) {
    TransformsIntrinsics in;
    in.fx = 100;
    in.fisheye = true;
    in.*term = 0.01;
    const auto camera = MakeCamera(in, 64, 48);
    EXPECT_EQ(camera.status().code(), StatusCode::kBadInput);
    EXPECT_THAT(camera.status().message(), HasSubstr("for a fisheye"));
  }
  for (double TransformsIntrinsics::*term : {&TransformsIntrinsics::k4,
                                             &TransformsIntrinsics::k5,
                                             &TransformsIntrinsics::k6}) {
    TransformsIntrinsics in;
    in.fx = 100;
    in.*term = 0.01;
    EXPECT_THAT(MakeCamera(in, 64, 48).status().message(),
                HasSubstr("FULL_OPENCV"));
    in.full_opencv = true;
    EXPECT_EQ(MakeCamera(in, 64, 48)->model, CameraModel::kFullOpenCv);
  }
}

TEST(MakeCamera, FieldOfViewAndDefaults) {
  TransformsIntrinsics in;
  in.angle_x = 0.6911112070083618;  // NeRF-synthetic.
  const auto camera = MakeCamera(in, 800, 800);
  ASSERT_TRUE(camera.ok());
  EXPECT_NEAR(camera->FocalX(), 1111.111, 1e-2);
  EXPECT_EQ(camera->FocalY(), camera->FocalX());
  EXPECT_EQ(camera->PrincipalX(), 400);
  in.angle_y = 0.5;
  EXPECT_NEAR(MakeCamera(in, 800, 800)->FocalY(), 400 / std::tan(0.25), 1e-9);
  TransformsIntrinsics none;
  EXPECT_FALSE(MakeCamera(none, 800, 800).ok());
}

TEST(MakeCamera, ScalesToThePhoto) {
  const auto file = ParseTransforms(kValid);
  const auto half = MakeCamera(file->frames[0].intrinsics, 500, 300);
  ASSERT_TRUE(half.ok());
  EXPECT_EQ(half->FocalX(), 500);
  EXPECT_EQ(half->PrincipalX(), 250.25);
  // A third, rounded down and up.
  EXPECT_TRUE(MakeCamera(file->frames[0].intrinsics, 333, 199).ok());
  EXPECT_TRUE(MakeCamera(file->frames[0].intrinsics, 334, 200).ok());
  for (const auto& [width, height] :
       {std::pair(995, 600), std::pair(1000, 604), std::pair(500, 302)}) {
    EXPECT_FALSE(MakeCamera(file->frames[0].intrinsics, width, height).ok())
        << width << " x " << height;  // Cropped.
  }
  const auto rotated = MakeCamera(file->frames[0].intrinsics, 600, 1000);
  ASSERT_FALSE(rotated.ok());
  EXPECT_THAT(rotated.status().message(), HasSubstr("1000 x 600"));
}

TEST(MakeCamera, OneSideIsEnough) {
  TransformsIntrinsics in;
  in.fx = 1000;
  in.width = 1600;
  EXPECT_EQ(MakeCamera(in, 800, 600)->FocalX(), 500);
  in.width = 0;
  in.height = 300;
  EXPECT_EQ(MakeCamera(in, 800, 600)->FocalX(), 2000);
}

// The camera of a file with `shared` in its root and `own` in its only frame.
Camera CameraOf(const std::string& shared, const std::string& own) {
  const auto file = ParseTransforms(
      R"({"fl_x": 100, )" + shared + R"("frames": [{"file_path": "a.png", )" +
      own + R"("transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0]]}]})");
  EXPECT_TRUE(file.ok()) << file.status().message();
  if (!file.ok()) return {};
  return *MakeCamera(file->frames.front().intrinsics, 64, 48);
}

// A file of wide-angle photos with one frame of a telephoto lens.
TEST(ParseTransforms, AFrameHasItsOwnFieldOfView) {
  const auto focal = [](const std::string& own) {
    const Camera camera =
        CameraOf(R"("fl_y": 101, "camera_angle_x": 0.7, )", own);
    return Eigen::Vector2d(camera.FocalX(), camera.FocalY());
  };
  using Eigen::Vector2d;
  const auto expect = [&](const std::string& own, double x, double y) {
    EXPECT_LT((focal(own) - Vector2d(x, y)).norm(), 1e-9) << own;
  };
  const double pi = std::acos(-1.0);
  const double angle = 32 / std::tan(0.15);
  const double degrees = 32 / std::tan(8.6 * pi / 180);
  expect("", 100, 101);
  expect(R"("camera_angle_x": 0.3, )", angle, angle);
  expect(R"("x_fov": 17.2, )", degrees, degrees);
  expect(R"("fl_x": 2117, )", 2117, 2117);
  expect(R"("fl_y": 2117, )", 2117, 2117);
  expect(R"("camera_angle_y": 0.3, )", angle * 0.75, angle * 0.75);
  expect(R"("camera_angle_x": 0.3, "fl_y": 300, )", angle, 300);
  expect(R"("x_fov": 17.2, "y_fov": 17.2, )", degrees, degrees * 0.75);
  // What is null or zero is not given.
  expect(R"("fl_x": null, "camera_angle_x": 0, )", 100, 101);
  // Several for one axis.
  expect(R"("fl_x": 50, "x_fov": 17.2, )", 50, 50);
  expect(R"("camera_angle_x": 0.5, "x_fov": 17.2, )", degrees, degrees);
}

TEST(ParseTransforms, TheFileMayHaveDegrees) {
  const auto file = ParseTransforms(
      R"({"x_fov": 90, "frames": [{"file_path": "a.png",
          "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0]]}]})");
  ASSERT_TRUE(file.ok()) << file.status().message();
  const auto camera = MakeCamera(file->frames[0].intrinsics, 64, 48);
  ASSERT_TRUE(camera.ok()) << camera.status().message();
  EXPECT_NEAR(camera->FocalX(), 32, 1e-9);
  EXPECT_NEAR(camera->FocalY(), 32, 1e-9);
}

TEST(ParseTransforms, EachCoordinateOfTheCentreCountsAlone) {
  const auto centre = [](const std::string& shared, const std::string& own) {
    const Camera camera = CameraOf(shared, own);
    return Eigen::Vector2d(camera.PrincipalX(), camera.PrincipalY());
  };
  using Eigen::Vector2d;
  EXPECT_EQ(centre(R"("cx": null, "cy": null, )", ""), Vector2d(32, 24));
  EXPECT_EQ(centre(R"("cx": 30, "cy": null, )", ""), Vector2d(30, 24));
  EXPECT_EQ(centre(R"("cx": 30, )", R"("cy": 20, )"), Vector2d(30, 20));
  EXPECT_EQ(centre(R"("cx": 30, "cy": 21, )", R"("cy": 20, "cx": null, )"),
            Vector2d(30, 20));
  EXPECT_EQ(centre(R"("cx": 0, "cy": 0, )", ""), Vector2d(0, 0));
}

TEST(ParseTransforms, FullOpenCvHasAllItsParameters) {
  const Camera camera = CameraOf(
      R"("camera_model": "FULL_OPENCV", "k1": 1e-1, "k2": 2e-2, "p1": 3e-3, )"
      R"("p2": 4e-3, "k3": 5e-3, "k4": 6e-3, "k5": 7e-3, "k6": 8e-3, )",
      "");
  EXPECT_EQ(camera.model, CameraModel::kFullOpenCv);
  EXPECT_THAT(
      camera.Distortion(),
      testing::ElementsAre(1e-1, 2e-2, 3e-3, 4e-3, 5e-3, 6e-3, 7e-3, 8e-3));
}

TEST(ParseTransforms, AFrameMayHaveAnotherKindOfCamera) {
  const std::string fisheye = R"("camera_model": "OPENCV_FISHEYE", )";
  const std::string plain = R"("camera_model": "OPENCV", )";
  EXPECT_EQ(CameraOf(fisheye, "").model, CameraModel::kOpenCvFisheye);
  EXPECT_EQ(CameraOf(fisheye, plain).model, CameraModel::kPinhole);
  EXPECT_EQ(CameraOf(plain, fisheye).model, CameraModel::kOpenCvFisheye);
  EXPECT_EQ(CameraOf(fisheye, R"("is_fisheye": false, )").model,
            CameraModel::kPinhole);
  EXPECT_EQ(CameraOf(R"("is_fisheye": true, )" + plain, "").model,
            CameraModel::kPinhole);
}

TEST(ParseTransforms, NullIsNoKindOfCamera) {
  const std::string nothing = R"("camera_model": null, "is_fisheye": null, )";
  const std::string fisheye = R"("camera_model": "OPENCV_FISHEYE", )";
  EXPECT_EQ(CameraOf(nothing, nothing).model, CameraModel::kPinhole);
  EXPECT_EQ(CameraOf(fisheye, nothing).model, CameraModel::kOpenCvFisheye);
  const Camera camera = CameraOf(nothing + R"("k1": 0.01, )", fisheye);
  EXPECT_THAT(camera.Distortion(), testing::ElementsAre(0.01, 0, 0, 0));
}

TEST(ParseTransforms, DistortionIsInheritedWithinAKind) {
  using testing::ElementsAre;
  const std::string fisheye = R"("camera_model": "OPENCV_FISHEYE", )";
  const std::string plain = R"("camera_model": "OPENCV", )";
  const std::string perspective = R"("k1": 0.1, "k2": 0.2, "p1": 0.3, )";
  const std::string round = R"("k1": 0.01, "k2": 0.02, "k3": 0, "k4": 0.04, )";
  Camera camera = CameraOf(plain + perspective + R"("p2": 0.4, )",
                           fisheye + R"("k1": 0.01, "k4": 0.04, )");
  EXPECT_EQ(camera.model, CameraModel::kOpenCvFisheye);
  EXPECT_THAT(camera.Distortion(), ElementsAre(0.01, 0, 0, 0.04));
  camera = CameraOf(fisheye + round, plain + perspective);
  EXPECT_EQ(camera.model, CameraModel::kOpenCv);
  EXPECT_THAT(camera.Distortion(), ElementsAre(0.1, 0.2, 0.3, 0));
  camera = CameraOf(plain + perspective, plain + R"("k2": 0.5, )");
  EXPECT_THAT(camera.Distortion(), ElementsAre(0.1, 0.5, 0.3, 0));
  // The file does not say what its numbers are for, and the frame does.
  camera = CameraOf(round, fisheye);
  EXPECT_THAT(camera.Distortion(), ElementsAre(0.01, 0.02, 0, 0.04));

  const std::string full = R"("camera_model": "FULL_OPENCV", "k4": 0.04, )";
  EXPECT_EQ(CameraOf(full, R"("is_fisheye": false, )").model,
            CameraModel::kFullOpenCv);
  camera = CameraOf(full, R"("is_fisheye": true, "k1": 0.01, )");
  EXPECT_EQ(camera.model, CameraModel::kOpenCvFisheye);
  EXPECT_THAT(camera.Distortion(), ElementsAre(0.01, 0, 0, 0));
}

TEST(ParseTransforms, WhatElseNerfstudioWrites) {
  const std::string frames =
      R"("frames":[{"file_path":"a.png",)"
      R"("transform_matrix":[[1,0,0,0],[0,1,0,0],[0,0,1,0]]}]})";
  const auto plain = ParseTransforms(R"({"fl_x":1,)" + frames);
  ASSERT_TRUE(plain.ok());
  EXPECT_TRUE(plain->holdout.empty());
  EXPECT_FALSE(plain->names_masks);
  EXPECT_TRUE(plain->points_file.empty());
  const auto full = ParseTransforms(
      R"({"fl_x":1,"train_filenames":["a.png"],"test_filenames":["b.png"],)"
      R"("val_filenames":["c.png"],"ply_file_path":"points.ply",)"
      R"("mask_path":"mask.png",)" +
      frames);
  ASSERT_TRUE(full.ok()) << full.status().message();
  EXPECT_THAT(full->holdout, testing::ElementsAre("b.png", "c.png"));
  EXPECT_TRUE(full->names_masks);
  EXPECT_EQ(full->points_file, "points.ply");
  const auto nulls = ParseTransforms(
      R"({"fl_x":1,"test_filenames":null,"ply_file_path":null,)" + frames);
  EXPECT_TRUE(nulls.ok());
  std::string masked = R"({"fl_x":1,)" + frames;
  masked.replace(masked.find(R"("transform)"), 0, R"("mask_path":"m.png",)");
  const auto with_masks = ParseTransforms(masked);
  ASSERT_TRUE(with_masks.ok()) << with_masks.status().message();
  EXPECT_TRUE(with_masks->names_masks);
}

std::string OneFrame(const std::string& matrix) {
  return R"({"fl_x":1,"frames":[{"file_path":"a.png","transform_matrix":)" +
         matrix + "}]}";
}

TEST(ParseTransforms, FaultsAreNamed) {
  const std::pair<std::string, const char*> cases[] = {
      {"", "JSON"},
      {"[1]", "object"},
      {"{}", "frames"},
      {R"({"frames":[]})", "frames"},
      {R"({"frames":[3]})", "frame 0"},
      {R"({"frames":[{}]})", "file_path"},
      {R"({"frames":[{"file_path":"a.png"}]})", "a.png"},
      {R"({"fl_x":"3","frames":[{}]})", "fl_x"},
      {R"({"fl_x":-3,"frames":[{}]})", "\"fl_x\" is negative"},
      {R"({"w":-3,"frames":[{}]})", "\"w\" is negative"},
      {R"({"test_filenames":"a.png","frames":[{}]})", "test_filenames"},
      {R"({"val_filenames":[1],"frames":[{}]})", "val_filenames"},
      {R"({"camera_model":"EQUIRECTANGULAR","frames":[{}]})",
       "EQUIRECTANGULAR"},
      {OneFrame("[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0]]"), "rows"},
      {OneFrame("[[1,0,0,0],[0,1,0,0],[0,0,1,null],[0,0,0,1]]"), "finite"},
      {OneFrame("[[1,0,0,0],[0,1,0,0],[0,0,1,1e300],[0,0,0,1]]"), "finite"},
      {OneFrame("[[1,0,0,0],[0,1,0,0],[0,0,1,NaN],[0,0,0,1]]"), "JSON"},
      {OneFrame("[[2,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]"), "rotation"},
      {OneFrame("[[0,0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,1]]"), "rotation"},
      {OneFrame("[[-1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]"), "rotation"},
      {OneFrame("[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,1,1]]"), "rotation"},
  };
  for (const auto& [text, fault] : cases) {
    const auto file = ParseTransforms(text);
    ASSERT_FALSE(file.ok()) << text;
    EXPECT_EQ(file.status().code(), StatusCode::kBadInput);
    EXPECT_THAT(file.status().message(), HasSubstr(fault)) << text;
  }
}

TEST(ParseTransforms, SurvivesMutations) {
  const std::string valid = kValid;
  for (size_t size = 0; size < valid.size(); ++size) {
    EXPECT_FALSE(ParseTransforms(valid.substr(0, size)).ok());
  }
  RandomStream random(2, 2);
  for (int round = 0; round < 5000; ++round) {
    std::string changed = valid;
    for (int i = 0; i < 3; ++i) {
      changed[random.Index(changed.size())] =
          "0123456789-+.eE\"[]{},: \n\\unltrfa\xff"[random.Index(33)];
    }
    const auto file = ParseTransforms(changed);
    if (!file.ok()) continue;
    for (const TransformsFrame& frame : file->frames) {
      (void)MakeCamera(frame.intrinsics, 1000, 600);
    }
  }
  // Very deep nesting.
  EXPECT_FALSE(ParseTransforms(std::string(1 << 20, '[')).ok());
}

}  // namespace
}  // namespace freegs::sfm
