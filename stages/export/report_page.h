// SPDX-License-Identifier: BSD-3-Clause
// Renders the report as one HTML page. It needs no network, and only its 3D
// view and its charts need scripts.
//
//   ReportData data = GatherReportData(workspace, num_gaussians);
//   data.views.push_back(view);                      // from report_views.h
//   const std::string html = RenderReportPage(data);

#ifndef FREEGS_STAGES_EXPORT_REPORT_PAGE_H_
#define FREEGS_STAGES_EXPORT_REPORT_PAGE_H_

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "stages/export/training_curve.h"

namespace freegs::stages {

// A figure at the top of the page. An empty value is shown as "not there".
struct ReportFigure {
  std::string name;
  std::string value;
  std::string note;  // Small, below the value.
};

// How long a stage took. The members are empty when it has no stage.json.
struct ReportStage {
  std::string name;
  std::optional<double> wall_seconds;
  std::optional<double> cpu_seconds;
  std::optional<int64_t> peak_memory_bytes;
};

// The pictures of one view. The paths are relative to the page; a path is empty
// when there is no such picture.
struct ReportView {
  std::string name;
  std::string photo;
  std::string render;
  std::string difference;
  std::string depth;
  std::string instances;
  std::optional<double> psnr;  // dB
  std::optional<double> ssim;
};

struct ReportInstance {
  int id = 0;
  std::array<uint8_t, 3> color = {0, 0, 0};
  int64_t num_gaussians = 0;
  std::optional<std::array<double, 3>> box_size;  // World units.
  std::string words;
};

// A file that the page links to.
struct ReportFile {
  std::string path;  // Relative to the page.
  std::string what;
  uint64_t bytes = 0;
};

// All strings are plain text; RenderReportPage escapes them.
struct ReportData {
  std::string title;
  std::string subtitle;
  std::vector<ReportFigure> figures;
  std::vector<std::string> warnings;

  // Whether the views are holdout views; else they are training views.
  bool views_are_holdout = true;
  std::vector<ReportView> views;

  TrainingCurves curves;

  bool has_instances = false;  // Whether stage bootstrap has left a result.
  std::vector<ReportInstance> instances;
  int num_words_withheld = 0;  // Instances that the model does not know.

  std::vector<ReportStage> stages;
  std::vector<ReportFile> files;
  std::string footer;

  // The page's script is beside it as viewer.js, with viewer.css, licenses.txt
  // and the scene in scene.js. If not, `no_viewer` says why.
  bool has_viewer = false;
  std::string no_viewer;
};

std::string RenderReportPage(const ReportData& data);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_REPORT_PAGE_H_
