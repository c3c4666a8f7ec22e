// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/report_page.h"

#include <algorithm>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "core/io/json_text.h"
#include "core/number_text.h"
#include "stages/export/html.h"
#include "stages/export/report_style.h"
#include "stages/scene/shipped_model.h"

namespace freegs::stages {
namespace {

constexpr char kNotThere[] = "<span class=\"quiet\">not there</span>";

void AppendFigures(const std::vector<ReportFigure>& figures,
                   std::string* html) {
  *html += "<dl class=\"figures\">\n";
  for (const ReportFigure& figure : figures) {
    *html +=
        "<div><dt>" + EscapeHtml(figure.name) + "</dt><dd class=\"value\">" +
        (figure.value.empty() ? kNotThere : EscapeHtml(figure.value)) + "</dd>";
    if (!figure.note.empty()) {
      *html += "<dd class=\"note\">" + EscapeHtml(figure.note) + "</dd>";
    }
    *html += "</div>\n";
  }
  *html += "</dl>\n";
}

void AppendPicture(const std::string& path,
                   const std::string& caption,
                   const std::string& view,
                   std::string* html) {
  *html += "<figure>";
  if (path.empty()) {
    *html += "<div class=\"nothing\">not there</div>";
  } else {
    const std::string url = EncodeUrlPath(path);
    *html += "<a href=\"" + url + "\"><img loading=\"lazy\" src=\"" + url +
             "\" alt=\"" + caption + " of " + EscapeHtml(view) + "\"></a>";
  }
  *html += "<figcaption>" + caption + "</figcaption></figure>\n";
}

void AppendViews(const ReportData& data, std::string* html) {
  *html += "<h2>Views</h2>\n";
  if (data.views.empty()) {
    *html += "<p class=\"quiet\">No view to show.</p>\n";
    return;
  }
  *html += data.views_are_holdout
               ? "<p class=\"quiet\">Photographs that training never saw.</p>\n"
               : "<p class=\"quiet\">Photographs that took part in training, "
                 "because no other one has a pose.</p>\n";
  for (const ReportView& view : data.views) {
    *html += "<section class=\"view\">\n<h3>" + EscapeHtml(view.name);
    std::string quality;
    if (view.psnr) quality += FormatFixed(*view.psnr, 2) + " dB";
    if (view.ssim) {
      quality += (quality.empty() ? "" : ", ") + std::string("SSIM ") +
                 FormatFixed(*view.ssim, 3);
    }
    if (!quality.empty()) *html += " <span>\u00b7 " + quality + "</span>";
    *html += "</h3>\n<div class=\"strip\">\n";
    AppendPicture(view.photo, "Photo", view.name, html);
    AppendPicture(view.render, "Render", view.name, html);
    AppendPicture(view.difference, "Difference \u00d7 4", view.name, html);
    AppendPicture(view.depth, "Depth", view.name, html);
    AppendPicture(view.instances, "Instances", view.name, html);
    *html += "</div>\n</section>\n";
  }
}

void AppendScene(const ReportData& data, std::string* html) {
  *html += "<h2>Scene</h2>\n";
  if (!data.has_viewer) {
    *html += "<p class=\"quiet\">There is no 3D view here: " +
             EscapeHtml(data.no_viewer) + "</p>\n";
    return;
  }
  *html +=
      "<div id=\"scene3d\" data-scene=\"scene.js\"><p class=\"quiet\">The 3D "
      "view needs scripts and WebGL 2; the pictures below need neither."
      "</p></div>\n";
}

void AppendCurves(const ReportData& data, std::string* html) {
  *html += "<h2>Training</h2>\n";
  if (data.curves.loss.size() < 2) {
    *html +=
        "<p class=\"quiet\">The course of the training is not there.</p>\n";
    return;
  }
  if (!data.has_viewer) {
    *html +=
        "<p class=\"quiet\">Its course is in reconstruct/progress.csv; the "
        "charts come with the 3D view.</p>\n";
    return;
  }
  const std::string json =
      JsonForScript(JsonText(TrainingCurvesJson(data.curves), -1));
  *html +=
      "<div class=\"charts\" id=\"training\"><p class=\"quiet\">The charts "
      "need scripts; the numbers are in reconstruct/progress.csv.</p></div>\n"
      "<script type=\"application/json\" id=\"curves\">" +
      json + "</script>\n";
}

std::string Swatch(const std::array<uint8_t, 3>& color) {
  char text[64];
  std::snprintf(text,
                sizeof(text),
                "style=\"background:#%02x%02x%02x\"",
                color[0],
                color[1],
                color[2]);
  return std::string("<span class=\"swatch\" ") + text + "></span>";
}

void AppendInstances(const ReportData& data, std::string* html) {
  *html += "<h2>Instances</h2>\n";
  if (!data.has_instances) {
    *html +=
        "<p class=\"quiet\">Instances are not there: stage bootstrap has "
        "not been run.</p>\n";
    return;
  }
  if (data.instances.empty()) {
    *html += "<p class=\"quiet\">No instance was found.</p>\n";
    return;
  }
  bool words = false;
  for (const ReportInstance& instance : data.instances) {
    words = words || !instance.words.empty();
  }
  *html += "<div class=\"scroll\"><table>\n<tr><th>Instance</th>" +
           std::string(words ? "<th>What</th>" : "") +
           "<th class=\"number\">Gaussians</th>"
           "<th class=\"number\">Box, world units</th></tr>\n";
  for (const ReportInstance& instance : data.instances) {
    *html += "<tr><td>" + Swatch(instance.color) + std::to_string(instance.id) +
             "</td>";
    if (words) *html += "<td>" + EscapeHtml(instance.words) + "</td>";
    *html += "<td class=\"number\">" + FormatCount(instance.num_gaussians) +
             "</td><td class=\"number\">";
    if (instance.box_size) {
      const std::array<double, 3>& size = *instance.box_size;
      const int decimals = DecimalsFor(*std::ranges::max_element(size));
      *html += FormatFixed(size[0], decimals) + " \u00d7 " +
               FormatFixed(size[1], decimals) + " \u00d7 " +
               FormatFixed(size[2], decimals);
    } else {
      *html += "\u2013";
    }
    *html += "</td></tr>\n";
  }
  *html += "</table></div>\n";
  if (data.num_words_withheld > 0) {
    *html += "<p class=\"quiet\">" + FormatCount(data.num_words_withheld) +
             (data.num_words_withheld == 1 ? " instance has no words: "
                                           : " instances have no words: ") +
             "the CLIP model does not know what that is. " +
             EscapeHtml(std::string(kOfficialModelAdvice)) + "</p>\n";
  }
}

void AppendStages(const std::vector<ReportStage>& stages, std::string* html) {
  *html +=
      "<h2>Stages</h2>\n<div class=\"scroll\"><table>\n<tr><th>Stage</th>"
      "<th class=\"number\">Time</th><th class=\"number\">CPU time</th>"
      "<th class=\"number\">Peak memory</th></tr>\n";
  for (const ReportStage& stage : stages) {
    *html += "<tr><td>" + EscapeHtml(stage.name) + "</td>";
    const auto cell = [html](const std::string& text) {
      *html += "<td class=\"number\">" + text + "</td>";
    };
    cell(stage.wall_seconds ? FormatSeconds(*stage.wall_seconds) : kNotThere);
    cell(stage.cpu_seconds ? FormatSeconds(*stage.cpu_seconds) : "");
    cell(stage.peak_memory_bytes
             ? FormatBytes(static_cast<double>(*stage.peak_memory_bytes))
             : "");
    *html += "</tr>\n";
  }
  *html += "</table></div>\n";
}

void AppendFiles(const std::vector<ReportFile>& files, std::string* html) {
  if (files.empty()) return;
  *html += "<h2>Files</h2>\n<div class=\"scroll\"><table>\n";
  for (const ReportFile& file : files) {
    const std::string name = file.path.substr(file.path.rfind('/') + 1);
    *html += "<tr><td><a href=\"" + EncodeUrlPath(file.path) + "\">" +
             EscapeHtml(name) + "</a></td><td>" + EscapeHtml(file.what) +
             "</td><td class=\"number\">" +
             FormatBytes(static_cast<double>(file.bytes)) + "</td></tr>\n";
  }
  *html += "</table></div>\n";
}

}  // namespace

std::string RenderReportPage(const ReportData& data) {
  std::string html =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\">\n<title>" +
      EscapeHtml(data.title) + "</title>\n<style>" + std::string(kReportStyle) +
      "</style>\n" +
      (data.has_viewer ? "<link rel=\"stylesheet\" href=\"viewer.css\">\n"
                       : "") +
      "</head>\n<body>\n<main>\n<header>\n<h1>" + EscapeHtml(data.title) +
      "</h1>\n";
  if (!data.subtitle.empty()) {
    html += "<p class=\"quiet\">" + EscapeHtml(data.subtitle) + "</p>\n";
  }
  for (const std::string& warning : data.warnings) {
    html += "<p class=\"warning\">" + EscapeHtml(warning) + "</p>\n";
  }
  html += "</header>\n";
  AppendFigures(data.figures, &html);
  if (data.has_viewer) html += "<section id=\"live\" hidden></section>\n";
  AppendScene(data, &html);
  AppendViews(data, &html);
  AppendCurves(data, &html);
  AppendInstances(data, &html);
  AppendStages(data.stages, &html);
  AppendFiles(data.files, &html);
  html += "<footer>" + EscapeHtml(data.footer);
  if (data.has_viewer) {
    html +=
        ". The 3D view holds work of others: <a "
        "href=\"licenses.txt\">licences</a>";
  }
  html += "</footer>\n</main>\n";
  // Large scenes: the page is there before its script.
  if (data.has_viewer) {
    html += "<script src=\"viewer.js\" defer></script>\n";
  }
  html += "</body>\n</html>\n";
  return html;
}

}  // namespace freegs::stages
