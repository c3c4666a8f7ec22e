// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/live_queries.h"

#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/json_text.h"
#include "pipeline/system_info.h"
#include "stages/view/query_body.h"

namespace freegs::stages {
namespace {

int HttpStatusOf(const Status& status) {
  switch (status.code()) {
    case StatusCode::kInvalidArgument:
      // Views are all that a well-formed question can name wrongly.
      return status.message().starts_with("view ") ? 404 : 400;
    case StatusCode::kBadInput:
      return 409;
    case StatusCode::kMissingDependency:
      return 503;
    default:
      return 500;
  }
}

}  // namespace

LiveQueries::LiveQueries(const std::filesystem::path& workspace,
                         QueryRequest defaults,
                         int max_questions)
    : defaults_(std::move(defaults)),
      pool_(pipeline::WorkingThreads(defaults_.threads)),
      turns_(max_questions),
      session_(workspace) {}

HttpResponse LiveQueries::Answer(std::string_view body) {
  StatusOr<PageQuestion> question = ParseQueryBody(body, defaults_);
  if (!question.ok()) return ErrorResponse(400, question.status().message());
  const Turns::Turn turn(&turns_);
  if (!turn) {
    return BusyResponse(
        "other questions are being answered; ask again in a few seconds");
  }
  if (const Status status = DecodePicture(&*question); !status.ok()) {
    return ErrorResponse(400, status.message());
  }
  const StatusOr<nlohmann::json> answer =
      session_.Ask(std::move(question->request), pool_);
  if (!answer.ok()) {
    return ErrorResponse(HttpStatusOf(answer.status()),
                         answer.status().message());
  }
  HttpResponse response;
  response.content_type = "application/json";
  response.body = JsonText(*answer, -1);
  return response;
}

nlohmann::json AnswerableQueries(const std::filesystem::path& workspace) {
  std::error_code error;
  const std::filesystem::path folder = workspace / "bootstrap";
  const bool model = std::filesystem::exists(
      workspace / "reconstruct" / "point_cloud.ply", error);
  const bool instances =
      model && std::filesystem::exists(folder / "instances.json", error) &&
      std::filesystem::exists(folder / "idsf.bin", error);
  const bool features =
      instances &&
      std::filesystem::exists(folder / "instance_features.json", error);
  std::string reason;
  if (!instances) {
    reason = "the scene has no instances yet; run stage bootstrap";
  } else if (!features) {
    reason =
        "the scene was made without semantics, so only clicks can be "
        "answered; run stage bootstrap again with --bootstrap.mode lift";
  }
  return {{"text", features},
          {"example", features},
          {"click", instances},
          {"reason", reason}};
}

}  // namespace freegs::stages
