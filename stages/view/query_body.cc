// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/query_body.h"

#include <cstdint>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/base64.h"
#include "core/io/json_fields.h"
#include "stages/scene/clip_input.h"

namespace freegs::stages {
namespace {

using nlohmann::json;

constexpr int kMaxLevel = 1000;
constexpr int kMaxHits = 1'000'000;
constexpr double kMaxPixel = 1e6;
constexpr size_t kMaxWords = 1000;  // Bytes; the model reads far fewer.
constexpr double kMaxMegapixels = 50;

Status UnknownMember(const std::string& name) {
  return InvalidArgumentError("there is no member of this name: " + name);
}

Status ReadTextQuestion(const json& value, QueryRequest* request) {
  FREEGS_ASSIGN_OR_RETURN(request->text, ReadText(&value, "text"));
  if (request->text->find_first_not_of(" \t\r\n") == std::string::npos) {
    return InvalidArgumentError("text: there are no words in it");
  }
  if (request->text->size() > kMaxWords) {
    return InvalidArgumentError("text: is longer than " +
                                std::to_string(kMaxWords) + " bytes");
  }
  return Status();
}

Status ReadExampleQuestion(const json& value, PageQuestion* question) {
  FREEGS_ASSIGN_OR_RETURN(const std::string text, ReadText(&value, "example"));
  StatusOr<std::string> bytes = DecodeBase64(text);
  if (!bytes.ok()) return bytes.status().Annotated("example");
  if (!bytes->starts_with("\xff\xd8") && !bytes->starts_with("\x89PNG")) {
    return InvalidArgumentError("example: is neither a JPEG nor a PNG file");
  }
  question->request.example = "picture";
  question->picture = *std::move(bytes);
  return Status();
}

Status ReadClickQuestion(const json& value, QueryRequest* request) {
  if (!value.is_object()) return InvalidArgumentError("click: not an object");
  for (const auto& [name, member] : value.items()) {
    if (name != "view" && name != "x" && name != "y" && name != "level") {
      return UnknownMember("click." + name);
    }
  }
  Status status;
  JsonObjectReader reader(value, "", "click", &status);
  ViewPlace place;
  place.view = reader.Text("view");
  place.numbers = {reader.Number("x", -kMaxPixel, kMaxPixel),
                   reader.Number("y", -kMaxPixel, kMaxPixel)};
  const int level =
      reader.Has("level") ? reader.Integer("level", -kMaxLevel, kMaxLevel) : 0;
  FREEGS_RETURN_IF_ERROR(status);
  request->click = std::move(place);
  if (level != 0) request->level = level;
  return Status();
}

Status ReadBody(std::string_view body, PageQuestion* question) {
  QueryRequest* const request = &question->request;
  FREEGS_ASSIGN_OR_RETURN(const json members, ParseJsonObject(body));
  int questions = 0;
  for (const auto& [name, value] : members.items()) {
    if (name == "text") {
      ++questions;
      FREEGS_RETURN_IF_ERROR(ReadTextQuestion(value, request));
    } else if (name == "example") {
      ++questions;
      FREEGS_RETURN_IF_ERROR(ReadExampleQuestion(value, question));
    } else if (name == "click") {
      ++questions;
      FREEGS_RETURN_IF_ERROR(ReadClickQuestion(value, request));
    } else if (name == "max_hits") {
      FREEGS_ASSIGN_OR_RETURN(request->max_hits,
                              ReadInteger(&value, 0, kMaxHits, name));
    } else if (name == "background") {
      FREEGS_ASSIGN_OR_RETURN(request->text_options.background,
                              ReadBool(&value, name));
    } else {
      return UnknownMember(name);
    }
  }
  if (questions != 1) {
    return InvalidArgumentError(
        "ask one question: \"text\", \"example\" or \"click\"");
  }
  return Status();
}

}  // namespace

StatusOr<PageQuestion> ParseQueryBody(std::string_view body,
                                      const QueryRequest& defaults) {
  PageQuestion question{.request = defaults, .picture = {}};
  const Status status = ReadBody(body, &question);
  // Whatever is wrong, the page has asked wrongly.
  if (!status.ok()) return InvalidArgumentError(status.message());
  return question;
}

Status DecodePicture(PageQuestion* question) {
  if (question->picture.empty()) return Status();
  StatusOr<UprightPhoto> photo =
      DecodeUprightPhoto(question->picture, kMaxMegapixels);
  if (!photo.ok()) {
    return InvalidArgumentError("example: " + photo.status().message());
  }
  question->request.example_pixels = std::move(photo->pixels);
  return Status();
}

}  // namespace freegs::stages
