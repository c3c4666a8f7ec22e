// SPDX-License-Identifier: BSD-3-Clause
// Writes messages to the console and to WORKSPACE/log.txt, and draws the line
// of a terminal that shows progress.

#ifndef FREEGS_PIPELINE_LOGGER_H_
#define FREEGS_PIPELINE_LOGGER_H_

#include <filesystem>
#include <fstream>
#include <mutex>
#include <ostream>
#include <string>

#include "pipeline/stage.h"

namespace freegs::pipeline {

// Whether `stream` is the program's standard error, and that a terminal.
bool IsTerminal(const std::ostream& stream);

// Several threads may use one logger. It never fails: a log file that cannot be
// written to is left out.
class Logger {
 public:
  // `terminal` tells whether `console` is a terminal (IsTerminal), on which a
  // line can be drawn again. An empty `file` means that there is no log file.
  Logger(std::ostream& console,
         bool terminal,
         const std::filesystem::path& file);

  // Writes a line to the console, after erasing the transient line, and to the
  // file, with time and level.
  void Log(LogLevel level, const std::string& text);

  // Writes a line to the file only.
  void LogToFile(LogLevel level, const std::string& text);

  // Draws `text` in place of the line that shows progress; an empty text erases
  // it. Does nothing when the console is not a terminal.
  void SetTransient(const std::string& text);

  bool terminal() const { return terminal_; }

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
