// SPDX-License-Identifier: BSD-3-Clause
// The target of a request: a path and parameters.

#ifndef FREEGS_STAGES_VIEW_REQUEST_TARGET_H_
#define FREEGS_STAGES_VIEW_REQUEST_TARGET_H_

#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace freegs::stages {

struct RequestTarget {
  // Decoded. It begins with '/' and has no empty, "." or ".." part, no
  // backslash and no control character, so that what follows the first '/' is a
  // relative name; that name is empty or ends with '/' for a folder.
  std::string path;

  // The parameters that follow the path, as in "?a=1&b=2", decoded. If two have
  // one name, the first counts.
  std::map<std::string, std::string> parameters;
};

// Nothing when the target is not of that form, such as for a path out of its
// folder ("/../x", "/%2e%2e/x", "/..\x") and for a bad percent code.
std::optional<RequestTarget> ParseRequestTarget(std::string_view target);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_REQUEST_TARGET_H_
