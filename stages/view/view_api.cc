// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/view_api.h"

#include <charconv>
#include <cstdint>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/cancellation.h"
#include "core/io/json_text.h"
#include "pipeline/workspace.h"
#include "splat/scene/ply_io.h"
#include "stages/query/file_stamp.h"
#include "stages/scene/scene_instances.h"
#include "stages/scene/training_scene.h"
#include "stages/scene/workspace_scene.h"
#include "stages/view/fallback_page.h"
#include "stages/view/open_file.h"
#include "stages/view/view_status.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

constexpr char kQueryPath[] = "/api/query";
constexpr char kBinary[] = "application/octet-stream";

HttpResponse NotFound() {
  return ErrorResponse(404, "there is no such page or file");
}

HttpResponse JsonResponse(std::string text) {
  HttpResponse response;
  response.content_type = "application/json";
  response.body = std::move(text);
  return response;
}

HttpResponse SharedResponse(std::shared_ptr<const std::string> content) {
  HttpResponse response;
  response.content_type = kBinary;
  response.shared = std::move(content);
  return response;
}

// The answer for what a workspace does not have (yet).
HttpResponse StatusResponse(const Status& status) {
  const bool unavailable = status.code() == StatusCode::kMissingDependency;
  const bool unready = status.code() == StatusCode::kBadInput;
  return ErrorResponse(unavailable ? 503 : (unready ? 409 : 500),
                       status.message());
}

HttpResponse FileBelow(const fs::path& root, const std::string& name) {
  StatusOr<std::shared_ptr<const OpenFile>> file = OpenBelow(root, name);
  if (!file.ok()) return NotFound();
  HttpResponse response;
  response.content_type = ContentType(name);
  response.file = *std::move(file);
  return response;
}

// The number before `suffix`: 12 of "12.ply". Nothing for other texts.
std::optional<int> NumberBefore(std::string_view suffix,
                                std::string_view text) {
  if (!text.ends_with(suffix)) return std::nullopt;
  text.remove_suffix(suffix.size());
  int number = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (text.empty() || error != std::errc() || stop != end || number < 0) {
    return std::nullopt;
  }
  return number;
}

// Whether a request is about another scene than that of this stamp. Ids that a
// page shows may be those of other objects in a newer scene.
bool IsAboutAnotherScene(const RequestTarget& target,
                         const std::string& stamp) {
  const auto asked = target.parameters.find("scene");
  return asked != target.parameters.end() && asked->second != stamp;
}

HttpResponse SceneHasChanged() {
  return ErrorResponse(
      409, "the scene has changed since this page was opened; load it again");
}

HttpResponse SceneIsBeingMade() {
  return BusyResponse("the scene is being made ready; ask again in a second");
}

}  // namespace

HttpResponse AnswerAboutScene(const fs::path& workspace,
                              const RequestTarget& target,
                              const std::function<HttpResponse()>& answer) {
  const auto has_another = [&] {
    return IsAboutAnotherScene(target, QueryStamp(workspace));
  };
  if (has_another()) return SceneHasChanged();
  HttpResponse response = answer();
  if (has_another()) return SceneHasChanged();
  return response;
}

ViewApi::ViewApi(const ViewApiOptions& options, AccessRules rules)
    : options_(options),
      rules_(std::move(rules)),
      queries_(options.workspace, options.query_defaults, options.max_at_once),
      scene_(options.workspace, options.make_scene),
      rate_(options.queries_per_second),
      instance_turns_(options.max_at_once) {}

std::optional<HttpResponse> ViewApi::Refuse(const HttpRequest& request) {
  const std::optional<RequestTarget> target =
      ParseRequestTarget(request.target);
  if (!target) return NotFound();
  const bool post = request.method == "POST";
  if ((post && target->path != kQueryPath) ||
      (!post && request.method != "GET" && request.method != "HEAD")) {
    HttpResponse response = ErrorResponse(
        405, "only GET is allowed, and POST for questions at /api/query");
    response.headers.emplace_back(
        "Allow", target->path == kQueryPath ? "POST" : "GET, HEAD");
    return response;
  }
  const AccessDecision access = CheckAccess(rules_, request, *target);
  if (access.status != 200) return ErrorResponse(access.status, access.error);
  if (post && !rate_.Take(SteadySeconds())) {
    return BusyResponse("too many questions; ask again in a second");
  }
  return std::nullopt;
}

HttpResponse ViewApi::Answer(const HttpRequest& request) {
  const std::optional<RequestTarget> target =
      ParseRequestTarget(request.target);
  if (!target) return NotFound();
  HttpResponse response = Route(request, *target);
  const AccessDecision access = CheckAccess(rules_, request, *target);
  if (!access.set_cookie.empty()) {
    response.headers.emplace_back("Set-Cookie", access.set_cookie);
  }
  return response;
}

HttpResponse ViewApi::Route(const HttpRequest& request,
                            const RequestTarget& target) {
  std::string_view name = target.path;
  const auto take = [&name](std::string_view prefix) {
    if (!name.starts_with(prefix)) return false;
    name.remove_prefix(prefix.size());
    return true;
  };
  if (request.method == "POST") {
    return AnswerAboutScene(options_.workspace, target, [&] {
      return queries_.Answer(request.body);
    });
  }
  if (name == "/") return FrontPage(target);
  // Browsers ask for it; the page has none.
  if (name == "/favicon.ico") return {.status = 204};
  if (take("/api/")) return Api(name, target);
  if (take("/web/")) return FileBelow(options_.web, std::string(name));
  std::string file(name.substr(1));
  if (file.ends_with('/')) file += "index.html";
  return FileBelow(pipeline::StageFolder(options_.workspace, "export"), file);
}

HttpResponse ViewApi::FrontPage(const RequestTarget& target) const {
  const fs::path folder = pipeline::StageFolder(options_.workspace, "export");
  if (OpenBelow(folder, "report/index.html").ok()) {
    HttpResponse response;
    response.status = 302;
    std::string location = "/report/";
    // After a click on another page, the browser does not send the cookie with
    // the second request.
    const auto token = target.parameters.find("token");
    if (token != target.parameters.end() && !rules_.token.empty()) {
      location += "?token=" + rules_.token;
    }
    response.headers.emplace_back("Location", location);
    return response;
  }
  HttpResponse live = FileBelow(options_.web, "live.html");
  return live.status == 200 ? live : StatusPage();
}

HttpResponse ViewApi::StatusPage() const {
  HttpResponse response;
  response.content_type = "text/html; charset=utf-8";
  response.body = kFallbackPage;
  return response;
}

HttpResponse ViewApi::Api(std::string_view name, const RequestTarget& target) {
  const auto take = [&name](std::string_view prefix) {
    if (!name.starts_with(prefix)) return false;
    name.remove_prefix(prefix.size());
    return true;
  };
  if (name == "status") {
    return JsonResponse(JsonText(ViewStatus(options_.workspace), -1));
  }
  if (name == "preview.jpg") {
    if (!pipeline::IsLocked(options_.workspace)) return NotFound();
    const fs::path file = pipeline::PreviewPath(options_.workspace);
    return FileBelow(file.parent_path(), file.filename().string());
  }
  if (name == "scene") {
    const auto scene = scene_.Get();
    if (!scene.ok()) return StatusResponse(scene.status());
    if (*scene == nullptr) return SceneIsBeingMade();
    HttpResponse response = JsonResponse((*scene)->description);
    response.headers.emplace_back("Scene-Stamp", (*scene)->stamp);
    return response;
  }
  if (take("photos/")) return Photo(std::string(name));
  if (take("instances/")) {
    return AnswerAboutScene(
        options_.workspace, target, [&] { return InstancePly(name); });
  }
  if (take("parts/")) return ScenePart(name, target);
  if (name == "query") {
    HttpResponse response = ErrorResponse(405, "ask with POST");
    response.headers.emplace_back("Allow", "POST");
    return response;
  }
  return NotFound();
}

StatusOr<bool> ViewApi::IsView(const std::string& name) {
  const std::lock_guard lock(views_mutex_);
  const std::string stamp = PhotosStamp(options_.workspace);
  if (stamp != views_stamp_) {
    views_.clear();
    views_stamp_.clear();
    FREEGS_ASSIGN_OR_RETURN(const PosedPhotos photos,
                            ReadPosedPhotos(options_.workspace));
    for (const auto* views : {&photos.train, &photos.holdout}) {
      for (const View& view : *views) views_.insert(view.name);
    }
    views_stamp_ = stamp;
  }
  return views_.contains(name);
}

HttpResponse ViewApi::Photo(const std::string& name) {
  const StatusOr<bool> known = IsView(name);
  if (!known.ok() || !*known) {
    return ErrorResponse(404, "there is no view of this name");
  }
  return FileBelow(options_.workspace / "undistort" / "images", name);
}

HttpResponse ViewApi::InstancePly(std::string_view name) {
  const std::optional<int> id = NumberBefore(".ply", name);
  if (!id) return NotFound();
  const Turns::Turn turn(&instance_turns_);
  if (!turn) {
    return BusyResponse(
        "other objects are being read; ask again in a few seconds");
  }
  StatusOr<splat::PlacedModel> world = ReadWorkspaceModel(options_.workspace);
  if (!world.ok()) return StatusResponse(world.status());
  const StatusOr<std::vector<int32_t>> labels =
      ReadInstanceLabels(options_.workspace, world->model.size());
  if (!labels.ok()) return StatusResponse(labels.status());
  const StatusOr<std::set<int32_t>> chosen = LabelsOfIds(*labels, {*id});
  if (!chosen.ok()) return ErrorResponse(404, chosen.status().message());
  std::vector<uint32_t> gaussians;
  for (size_t i = 0; i < labels->size(); ++i) {
    if (chosen->contains((*labels)[i])) {
      gaussians.push_back(static_cast<uint32_t>(i));
    }
  }
  world->model.Select(gaussians);
  HttpResponse response = SharedResponse(std::make_shared<const std::string>(
      splat::SerializePly(world->model, world->offset)));
  // Without a name: the page's own, with the words of the object, is better.
  response.headers.emplace_back("Content-Disposition", "attachment");
  return response;
}

HttpResponse ViewApi::ScenePart(std::string_view name,
                                const RequestTarget& target) {
  const bool labels = name.ends_with("/labels.bin");
  const std::optional<int> number =
      NumberBefore(labels ? "/labels.bin" : "/splats.spz", name);
  if (!number) return NotFound();
  const auto scene = scene_.Get();
  if (!scene.ok()) return StatusResponse(scene.status());
  if (*scene == nullptr) return SceneIsBeingMade();
  if (IsAboutAnotherScene(target, (*scene)->stamp)) return SceneHasChanged();
  const auto index = static_cast<size_t>(*number);
  if (index >= (*scene)->parts.size()) return NotFound();
  const SceneParts::Part& part = (*scene)->parts[index];
  return SharedResponse(labels ? part.labels : part.splats);
}

}  // namespace freegs::stages
