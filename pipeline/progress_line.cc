// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/progress_line.h"

#include <algorithm>
#include <cmath>
#include <sys/ioctl.h>
#include <unistd.h>

#include "core/number_text.h"

namespace freegs::pipeline {
namespace {

constexpr double kTerminalInterval = 0.1;
constexpr double kPlainInterval = 10;
constexpr double kRateWindow = 30;
constexpr double kRateUnits = 20;
constexpr double kRateSpacing = 0.5;

// Whole numbers without a point, others with two places.
std::string Count(double value) {
  const bool whole = std::abs(value - std::round(value)) < 1e-9;
  return FormatFixed(value, whole ? 0 : 2);
}

size_t TerminalWidth() {
  winsize size = {};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20) {
    return size.ws_col;
  }
  return 80;
}

// The line must not wrap, or it could not be drawn over. A cut never leaves
// half of a UTF-8 character.
std::string Fit(const std::string& line, size_t width) {
  if (line.size() < width) return line;
  size_t end = width - 1;
  while (end > 0 && (static_cast<unsigned char>(line[end]) & 0xc0) == 0x80) {
    --end;
  }
  return line.substr(0, end);
}

}  // namespace

std::string FormatProgress(const Progress& progress, double rate) {
  std::string text = progress.step + " " + Count(progress.done);
  if (progress.total > 0) {
    const double share = std::clamp(progress.done / progress.total, 0.0, 1.0);
    text += "/" + Count(progress.total) + " " +
            FormatFixed(std::floor(100 * share), 0) + "%";
  }
  if (rate > 0) {
    text += " " + (rate >= 0.1 ? FormatFixed(rate, 1) + "/s"
                               : FormatFixed(60 * rate, 1) + "/min");
    if (progress.total > progress.done) {
      text += " " + FormatSeconds((progress.total - progress.done) / rate) +
              " left";
    }
  }
  if (!progress.detail.empty()) text += ", " + progress.detail;
  return text;
}

double ProgressRate::Update(double now, const Progress& progress) {
  if (progress.step != step_) {
    step_ = progress.step;
    recent_.clear();
  }
  const double done = progress.done;
  if (!recent_.empty() && done < recent_.back().second) recent_.clear();
  if (recent_.empty() || now - recent_.back().first >= kRateSpacing) {
    recent_.emplace_back(now, done);
  }
  while (recent_.size() > 2 && now - recent_[1].first >= kRateWindow &&
         done - recent_[1].second >= kRateUnits) {
    recent_.pop_front();
  }
  const double seconds = now - recent_.front().first;
  return seconds >= kRateSpacing ? (done - recent_.front().second) / seconds
                                 : 0;
}

ProgressLine::ProgressLine(Logger* logger,
                           std::string prefix,
                           ExpectedSeconds expected,
                           Clock clock)
    : logger_(logger),
      prefix_(std::move(prefix)),
      expected_(expected),
      clock_(clock ? std::move(clock) : SteadySeconds),
      begin_(clock_()) {}

ProgressLine::~ProgressLine() { logger_->SetTransient(""); }

std::string ProgressLine::LeftText(double now,
                                   const Progress& progress,
                                   double rate) const {
  if (expected_.stage <= 0) return "";
  const double step =
      rate > 0 ? std::max(0.0, progress.total - progress.done) / rate : 0;
  const double stage = std::max(expected_.stage - (now - begin_), step);
  return " (" + FormatSeconds(std::max(1.0, stage + expected_.later)) +
         " left for all)";
}

void ProgressLine::Report(const Progress& progress) {
  const std::lock_guard lock(mutex_);
  const double now = clock_();
  if (progress.step != step_) {
    step_ = progress.step;
    shown_ = false;
  }
  const double rate = rate_.Update(now, progress);
  const double interval =
      logger_->terminal() ? kTerminalInterval : kPlainInterval;
  if (shown_ && now - last_shown_ < interval) return;
  shown_ = true;
  last_shown_ = now;
  const std::string line = prefix_ + LeftText(now, progress, rate) + ": " +
                           FormatProgress(progress, rate);
  if (logger_->terminal()) {
    logger_->SetTransient(Fit(line, TerminalWidth()));
  } else {
    logger_->Log(LogLevel::kInfo, line);
  }
}

}  // namespace freegs::pipeline
