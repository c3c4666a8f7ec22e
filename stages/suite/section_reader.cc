// SPDX-License-Identifier: BSD-3-Clause

#include "stages/suite/section_reader.h"

#include <cstdlib>
#include <optional>
#include <utility>

#include "pipeline/option_value.h"

namespace freegs::stages {
namespace {

constexpr size_t kMaxWords = 10000;

std::optional<std::string> FromEnvironment(const std::string& name) {
  if (name == "scene") return "${scene}";
  const char* value = std::getenv(name.c_str());
  if (value == nullptr) return std::nullopt;
  return std::string(value);
}

}  // namespace

Status ParseWords(const std::string& text, std::vector<std::string>* words) {
  FREEGS_ASSIGN_OR_RETURN(*words, SplitWords(text));
  if (words->empty()) return InvalidArgumentError("no value");
  if (words->size() > kMaxWords) {
    return InvalidArgumentError("more than 10000 values");
  }
  return Status();
}

void SectionReader::On(const std::string& key, ReadFn read) {
  known_[key] = std::move(read);
}

void SectionReader::OnText(const std::string& key, std::string* target) {
  On(key, [target](const std::string& value) {
    *target = value;
    return Status();
  });
}

void SectionReader::OnWords(const std::string& key,
                            std::vector<std::string>* target) {
  On(key,
     [target](const std::string& value) { return ParseWords(value, target); });
}

void SectionReader::OnBool(const std::string& key, bool* target) {
  On(key, [target](const std::string& value) {
    *target = value == "true";
    return value == "true" || value == "false"
               ? Status()
               : InvalidArgumentError("'" + value + "' is not true or false");
  });
}

Status SectionReader::Read(const IniSection& section,
                           const OtherFn& other) const {
  for (const auto& [key, raw] : section.entries) {
    const StatusOr<std::string> value = ExpandVariables(raw, FromEnvironment);
    Status status = value.status();
    const auto known = known_.find(key);
    if (status.ok() && known != known_.end()) {
      status = known->second(*value);
    } else if (status.ok()) {
      status = other ? other(key, *value) : Unknown(key);
    }
    if (!status.ok()) return status.Annotated(section.Title() + " " + key);
  }
  return Status();
}

Status SectionReader::Unknown(const std::string& key) const {
  std::vector<std::string> names;
  std::string all;
  for (const auto& [name, read] : known_) {
    names.push_back(name);
    all += (all.empty() ? "" : ", ") + name;
  }
  const std::string nearest = pipeline::NearestName(key, names);
  return InvalidArgumentError(
      "unknown key; " +
      (nearest.empty() ? "there are " + all : "did you mean " + nearest + "?"));
}

}  // namespace freegs::stages
