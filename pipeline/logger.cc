// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/logger.h"

#include <cstdlib>
#include <ctime>
#include <iostream>
#include <string_view>
#include <unistd.h>

namespace freegs::pipeline {
namespace {

constexpr char kEraseLine[] = "\r\x1b[K";

std::string TimeStamp() {
  const std::time_t now = std::time(nullptr);
  std::tm parts = {};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

const char* Prefix(LogLevel level) {
  switch (level) {
    case LogLevel::kInfo:
      return "";
    case LogLevel::kWarning:
      return "warning: ";
    case LogLevel::kError:
      return "error: ";
  }
  return "";
}

}  // namespace

bool IsTerminal(const std::ostream& stream) {
  const char* type = std::getenv("TERM");
  return &stream == &std::cerr && isatty(STDERR_FILENO) != 0 &&
         type != nullptr && std::string_view(type) != "dumb";
}

Logger::Logger(std::ostream& console,
               bool terminal,
               const std::filesystem::path& file)
    : console_(console), terminal_(terminal) {
  if (!file.empty()) file_.open(file, std::ios::app);
}

void Logger::Log(LogLevel level, const std::string& text) {
  const std::lock_guard lock(mutex_);
  if (transient_shown_) console_ << kEraseLine;
  transient_shown_ = false;
  console_ << Prefix(level) << text << "\n";
  console_.flush();
  WriteFileLine(level, text);
}

void Logger::LogToFile(LogLevel level, const std::string& text) {
  const std::lock_guard lock(mutex_);
  WriteFileLine(level, text);
}

void Logger::SetTransient(const std::string& text) {
  if (!terminal_) return;
  const std::lock_guard lock(mutex_);
  if (text.empty() && !transient_shown_) return;
  console_ << kEraseLine << text;
  console_.flush();
  transient_shown_ = !text.empty();
}

void Logger::WriteFileLine(LogLevel level, const std::string& text) {
  if (!file_.is_open()) return;
  // After a line that found the disk full, the next ones may find room.
  file_.clear();
  file_ << TimeStamp() << " " << Prefix(level) << text << "\n";
  file_.flush();
}

}  // namespace freegs::pipeline
