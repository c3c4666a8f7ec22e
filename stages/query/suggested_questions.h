// SPDX-License-Identifier: BSD-3-Clause
// Questions for somebody who has a new scene and has never asked one.

#ifndef FREEGS_STAGES_QUERY_SUGGESTED_QUESTIONS_H_
#define FREEGS_STAGES_QUERY_SUGGESTED_QUESTIONS_H_

#include <filesystem>
#include <string>
#include <vector>

#include "core/status.h"

namespace freegs::stages {

// Returns at most `max_questions` questions about what is in the scene, each as
// the words that follow `query WORKSPACE`: {"--text", "red ball"} or
// {"--click", "photo7.jpg", "412", "230"}.
//
// Texts come first, the names of the largest things that have one, and leave
// room for one click at least. Clicks are in the view in the middle of the
// list, on the largest things that it shows whole and then on others, each at
// its pixel farthest from its outline. Large planes such as floor and walls are
// not asked for. There are fewer questions when fewer things are seen.
//
// kBadInput names the file of the workspace that is missing or malformed.
StatusOr<std::vector<std::vector<std::string>>> SuggestQuestions(
    const std::filesystem::path& workspace, int max_questions);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_QUERY_SUGGESTED_QUESTIONS_H_
