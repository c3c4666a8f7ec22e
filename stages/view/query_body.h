// SPDX-License-Identifier: BSD-3-Clause
// Reads a question that a page sends.

#ifndef FREEGS_STAGES_VIEW_QUERY_BODY_H_
#define FREEGS_STAGES_VIEW_QUERY_BODY_H_

#include <string>
#include <string_view>

#include "core/status.h"
#include "stages/query/query_request.h"

namespace freegs::stages {

struct PageQuestion {
  QueryRequest request;
  // The file of an example; DecodePicture reads its pixels.
  std::string picture;
};

// Reads exactly one of
//   {"text": "red apple"}
//   {"example": "<base64 of a JPEG or PNG file>"}
//   {"click": {"view": "a.jpg", "x": 412, "y": 230, "level": 0}}
// with or without "max_hits" and "background". What is not there is as in
// `defaults`. kInvalidArgument names the member and what is wrong with it.
StatusOr<PageQuestion> ParseQueryBody(std::string_view body,
                                      const QueryRequest& defaults);

// Reads the picture of an example, if there is one, which takes up to a second
// and 150 MB. kInvalidArgument if it cannot be read.
Status DecodePicture(PageQuestion* question);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_QUERY_BODY_H_
