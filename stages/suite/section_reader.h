// SPDX-License-Identifier: BSD-3-Clause
// Reads the entries of one section of a suite into variables.

#ifndef FREEGS_STAGES_SUITE_SECTION_READER_H_
#define FREEGS_STAGES_SUITE_SECTION_READER_H_

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/status.h"
#include "stages/suite/ini_sections.h"

namespace freegs::stages {

// The words of a value: 1 to 10000.
Status ParseWords(const std::string& text, std::vector<std::string>* words);

//   SectionReader reader;
//   reader.OnText("title", &title);
//   reader.OnBool("log_x", &log_x);
//   FREEGS_RETURN_IF_ERROR(reader.Read(section));
class SectionReader {
 public:
  using ReadFn = std::function<Status(const std::string& value)>;
  using OtherFn =
      std::function<Status(const std::string& key, const std::string& value)>;

  // Targets must outlive the reader.
  void On(const std::string& key, ReadFn read);
  void OnText(const std::string& key, std::string* target);
  void OnWords(const std::string& key, std::vector<std::string>* target);
  void OnBool(const std::string& key, bool* target);

  // Reads all entries. Variables in values are those of the environment, but
  // ${scene} stays as it is. Keys that are not known go to `other`; without one
  // they are an error. kInvalidArgument names the section and the key.
  Status Read(const IniSection& section, const OtherFn& other = {}) const;

 private:
  Status Unknown(const std::string& key) const;

  std::map<std::string, ReadFn> known_;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SUITE_SECTION_READER_H_
