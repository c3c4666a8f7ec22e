// SPDX-License-Identifier: BSD-3-Clause

#include "stages/query/query_engine.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/number_text.h"
#include "semantics/clip/relevancy.h"
#include "semantics/queries/click_query.h"
#include "semantics/queries/instance_features.h"
#include "stages/query/lap.h"
#include "stages/query/query_level.h"
#include "stages/scene/clip_input.h"
#include "stages/scene/shipped_model.h"
#include "stages/scene/view_selection.h"

namespace freegs::stages {
namespace {

// Fills the answer from the scores of all instances, in descending order. Large
// planes become hits only when they are asked for; otherwise the answer
// mentions one that is better than all hits.
void FillFrom(const std::vector<ScoredInstance>& all,
              const QueryScene& scene,
              const QueryRequest& request,
              QueryAnswer* answer) {
  std::vector<ScoredInstance> scored;
  for (const ScoredInstance& instance : all) {
    const auto place = static_cast<size_t>(instance.id) - 1;
    const bool plane = scene.is_background[place] != 0;
    if (!plane || request.text_options.background) {
      scored.push_back(instance);
    } else if (scored.empty() && !answer->plane) {
      answer->plane = instance;
    }
  }
  SplitHits(scored, request.max_hits, answer);
}

// False for an instance that the model had no word for, or none that it was
// sure of.
bool HasWords(const QueryScene& scene, int id) {
  return std::any_of(scene.instances.begin(),
                     scene.instances.end(),
                     [id](const semantics::Instance& instance) {
                       return instance.id == id && !instance.words.empty();
                     });
}

// Opens the scene's model, if that was not done for an earlier question.
Status OpenNetworks(const QueryRequest& request,
                    const QueryScene& scene,
                    QueryNetworks* networks) {
  if (networks->clip) return Status();
  FREEGS_ASSIGN_OR_RETURN(
      networks->clip,
      OpenModelOfFeatures(*scene.features, request.workspace, request.model));
  return Status();
}

Status AnswerText(const QueryRequest& request,
                  const QueryScene& scene,
                  QueryNetworks* networks,
                  QueryAnswer* answer) {
  Lap lap;
  FREEGS_RETURN_IF_ERROR(OpenNetworks(request, scene, networks));
  semantics::OpenCvClip& encoder = *networks->clip;
  FREEGS_ASSIGN_OR_RETURN(const semantics::TextEmbedding text,
                          semantics::EncodeWords(*request.text, encoder));
  if (text.truncated) {
    answer->note +=
        "query: the words are too long for the model; it sees only their "
        "beginning\n";
  }
  if (networks->canonical.empty()) {
    FREEGS_ASSIGN_OR_RETURN(networks->canonical,
                            semantics::EncodeCanonicalPhrases(encoder));
  }
  answer->encode_ms = lap.Milliseconds();

  answer->question = {{"kind", "text"}, {"text", *request.text}};
  answer->words = "text \"" + *request.text + "\"";
  answer->score_name = "relevancy";
  answer->threshold = request.text_options.min_relevancy;
  FREEGS_ASSIGN_OR_RETURN(
      const std::vector<semantics::TextHit> hits,
      semantics::QueryText(*scene.features,
                           text.values,
                           networks->canonical,
                           {.min_relevancy = 0, .background = true}));
  std::vector<ScoredInstance> all;
  for (const semantics::TextHit& hit : hits) {
    all.push_back({hit.id, hit.relevancy, hit.cosine, std::nullopt});
  }
  FillFrom(all, scene, request, answer);
  answer->query_ms = lap.Milliseconds();
  if (!answer->hits.empty() && encoder.info().min_word_confidence > 0 &&
      !HasWords(scene, answer->hits[0].id)) {
    answer->note += "query: the model does not know what instance " +
                    std::to_string(answer->hits[0].id) +
                    " is, so this answer is a guess. ";
    answer->note += kOfficialModelAdvice;
    answer->note += "\n";
  }
  return Status();
}

Status AnswerExample(const QueryRequest& request,
                     const QueryScene& scene,
                     QueryNetworks* networks,
                     QueryAnswer* answer) {
  Lap lap;
  UprightPhoto photo;
  const ImageU8* picture = &request.example_pixels;
  if (picture->empty()) {
    FREEGS_ASSIGN_OR_RETURN(photo, ReadUprightPhoto(*request.example));
    picture = &photo.pixels;
  }
  FREEGS_RETURN_IF_ERROR(OpenNetworks(request, scene, networks));
  FREEGS_ASSIGN_OR_RETURN(const std::vector<float> image,
                          networks->clip->EncodeImage(*picture));
  answer->encode_ms = lap.Milliseconds();

  answer->question = {{"kind", "example"},
                      {"image", request.example->string()}};
  answer->words = "example " + request.example->string();
  answer->score_name = "cosine";
  answer->threshold = request.min_cosine;
  FREEGS_ASSIGN_OR_RETURN(
      const std::vector<semantics::ExampleHit> hits,
      semantics::QueryExample(*scene.features, image, {.background = true}));
  std::vector<ScoredInstance> all;
  for (const semantics::ExampleHit& hit : hits) {
    all.push_back({hit.id, hit.cosine, hit.cosine, std::nullopt});
  }
  FillFrom(all, scene, request, answer);
  answer->query_ms = lap.Milliseconds();
  return Status();
}

// Finds the view by name among those of --cameras, or among the photos when
// none of the file's has that name. The two can have the same names, but other
// sizes and poses.
StatusOr<View> ViewOf(const QueryScene& scene, const std::string& name) {
  std::vector<View> views = scene.file_views;
  const auto is_named = [&name](const View& view) {
    return HasViewName(view, name);
  };
  if (std::none_of(views.begin(), views.end(), is_named)) {
    views.insert(views.end(), scene.photos.begin(), scene.photos.end());
  }
  return FindView(views, name);
}

Status CheckListed(const QueryScene& scene, int id) {
  for (const semantics::Instance& instance : scene.instances) {
    if (instance.id == id) return Status();
  }
  return BadInputError("bootstrap/idsf.bin: has an instance " +
                       std::to_string(id) +
                       " that instances.json has not; run stage bootstrap "
                       "again");
}

std::string Place(const ViewPlace& place) {
  std::string text = place.view;
  for (const double number : place.numbers) {
    text += " " + FormatFixed(number, number == std::floor(number) ? 0 : 2);
  }
  return text;
}

StatusOr<std::vector<semantics::ClickHit>> InstancesAt(
    const QueryScene& scene,
    const View& view,
    const semantics::Pixel& pixel,
    ThreadPool& pool) {
  return semantics::QueryClick(
      scene.scene->model, scene.labels, view, scene.scene->render, pixel, pool);
}

// Another level of the hierarchy takes the place of the best hit, which is the
// clicked instance. The other hits stay what they are: what the region leaves
// of their instances is no instance.
Status ChangeLevel(const QueryRequest& request,
                   const ClickedInstance& clicked,
                   ThreadPool& pool,
                   QueryScene* scene,
                   std::vector<semantics::ClickHit>* hits,
                   QueryAnswer* answer) {
  const int level = *request.level;
  FREEGS_ASSIGN_OR_RETURN(
      const int id, AddLevel(request.workspace, clicked, level, pool, scene));
  FREEGS_ASSIGN_OR_RETURN(
      const std::vector<semantics::ClickHit> with_region,
      InstancesAt(*scene, clicked.view, clicked.pixel, pool));
  for (const semantics::ClickHit& hit : with_region) {
    if (hit.id == id) (*hits)[0] = hit;
  }
  answer->question["level"] = level;
  answer->question["instance"] = clicked.id;
  answer->words += level > 0 ? ", " + std::to_string(level) + " wider"
                             : ", " + std::to_string(-level) + " narrower";
  answer->words += " than instance " + std::to_string(clicked.id);
  return Status();
}

Status AnswerClick(const QueryRequest& request,
                   ThreadPool& pool,
                   QueryScene* scene,
                   QueryAnswer* answer) {
  const ViewPlace& place = *request.click;
  FREEGS_ASSIGN_OR_RETURN(const View view, ViewOf(*scene, place.view));
  const double x = std::floor(place.numbers[0]);
  const double y = std::floor(place.numbers[1]);
  if (x < 0 || y < 0 || x >= view.camera.width || y >= view.camera.height) {
    return InvalidArgumentError("--click " + Place(place) + ": view " +
                                view.name + " is " +
                                std::to_string(view.camera.width) + " x " +
                                std::to_string(view.camera.height) + " pixels");
  }
  Lap lap;
  answer->question = {{"kind", "click"},
                      {"view", view.name},
                      {"x", place.numbers[0]},
                      {"y", place.numbers[1]}};
  answer->words = "click " + Place(place);
  answer->score_name = "weight";
  const semantics::Pixel pixel{static_cast<int>(x), static_cast<int>(y)};
  FREEGS_ASSIGN_OR_RETURN(std::vector<semantics::ClickHit> all,
                          InstancesAt(*scene, view, pixel, pool));
  if (request.level && !all.empty()) {
    const ClickedInstance clicked{
        .view = view, .pixel = pixel, .id = all[0].id};
    FREEGS_RETURN_IF_ERROR(
        ChangeLevel(request, clicked, pool, scene, &all, answer));
  }
  answer->query_ms = lap.Milliseconds();
  std::vector<ScoredInstance> scored;
  for (const semantics::ClickHit& hit : all) {
    FREEGS_RETURN_IF_ERROR(CheckListed(*scene, hit.id));
    scored.push_back({hit.id,
                      hit.weight,
                      std::nullopt,
                      scene->scene->frame.WorldFromFrame() * hit.point});
  }
  SplitHits(scored, request.level ? 1 : request.max_hits, answer);
  return Status();
}

Status AnswerBox(const QueryRequest& request,
                 const QueryScene& scene,
                 ThreadPool& pool,
                 QueryAnswer* answer) {
  const ViewPlace& place = *request.box;
  FREEGS_ASSIGN_OR_RETURN(const View view, ViewOf(scene, place.view));
  Lap lap;
  const Image<int32_t> labels =
      RenderLabels(*scene.scene, view, scene.labels, pool);
  const StatusOr<std::vector<semantics::BoxHit>> hits = semantics::QueryBox(
      labels,
      {place.numbers[0], place.numbers[1], place.numbers[2], place.numbers[3]},
      {.background = true});
  if (!hits.ok()) return hits.status().Annotated("--box " + Place(place));
  answer->query_ms = lap.Milliseconds();
  answer->question = {
      {"kind", "box"}, {"view", view.name}, {"box", place.numbers}};
  answer->words = "box " + Place(place);
  answer->score_name = "iou";
  std::vector<ScoredInstance> all;
  for (const semantics::BoxHit& hit : *hits) {
    FREEGS_RETURN_IF_ERROR(CheckListed(scene, hit.id));
    all.push_back({hit.id, hit.iou, std::nullopt, std::nullopt});
  }
  FillFrom(all, scene, request, answer);
  return Status();
}

// Says how many instances nothing is known of: those were not compared.
void NoteUnknown(const semantics::InstanceFeatures& features,
                 QueryAnswer* answer) {
  size_t num_unknown = 0;
  for (size_t i = 0; i < features.size(); ++i) {
    num_unknown += features.known(i) ? 0 : 1;
  }
  if (num_unknown == 0 || !answer->hits.empty()) return;
  answer->note += "query: " + std::to_string(num_unknown) + " of " +
                  std::to_string(features.size()) +
                  " instances were not compared: no photograph that the stage "
                  "bootstrap looked at shows them well\n";
}

}  // namespace

StatusOr<QueryAnswer> FindAnswer(const QueryRequest& request,
                                 ThreadPool& pool,
                                 QueryScene* scene,
                                 QueryNetworks* networks) {
  QueryAnswer answer;
  Status status;
  if (request.text) {
    status = AnswerText(request, *scene, networks, &answer);
    if (status.ok()) NoteUnknown(*scene->features, &answer);
  } else if (request.example) {
    status = AnswerExample(request, *scene, networks, &answer);
    if (status.ok()) NoteUnknown(*scene->features, &answer);
  } else if (request.click) {
    status = AnswerClick(request, pool, scene, &answer);
  } else {
    status = AnswerBox(request, *scene, pool, &answer);
  }
  FREEGS_RETURN_IF_ERROR(status);
  return answer;
}

}  // namespace freegs::stages
