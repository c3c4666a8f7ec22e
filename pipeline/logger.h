// SPDX-License-Identifier: BSD-3-Clause
// Messages to the console and to WORKSPACE/log.txt, and the one line of a
// terminal that is drawn over and over.

#ifndef FREEGS_PIPELINE_LOGGER_H_
#define FREEGS_PIPELINE_LOGGER_H_

#include <filesystem>
#include <fstream>
#include <mutex>
#include <ostream>
#include <string>

#include "pipeline/stage.h"

namespace freegs::pipeline {

// Thread-safe. Never fails: a log file that cannot be written is left out.
class Logger {
 public:
  // `terminal`: whether `console` understands \r and an erase sequence. An
  // empty `file` logs to the console only.
  Logger(std::ostream& console,
         bool terminal,
         const std::filesystem::path& file);

  // A line on the console and, with time and level, in the file. A transient
  // line is erased first.
  void Log(LogLevel level, const std::string& text);

  // Into the file only.
  void LogToFile(LogLevel level, const std::string& text);

  // Replaces the transient line; an empty text erases it. Nothing happens when
  // the console is not a terminal.
  void SetTransient(const std::string& text);

  bool terminal() const { return terminal_; }
  LogFn function();

 private:
  void WriteFileLine(LogLevel level, const std::string& text);

  std::mutex mutex_;
  std::ostream& console_;
  const bool terminal_;
  std::ofstream file_;
  bool transient_shown_ = false;
};

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_LOGGER_H_
