// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/http_message.h"

#include <nlohmann/json.hpp>

#include "core/io/json_text.h"

namespace freegs::stages {

HttpResponse ErrorResponse(int status, const std::string& text) {
  HttpResponse response;
  response.status = status;
  response.content_type = "application/json";
  response.body = JsonText({{"error", text}}, -1);
  return response;
}

HttpResponse BusyResponse(const std::string& text) {
  HttpResponse response = ErrorResponse(429, text);
  response.headers.emplace_back("Retry-After", "1");
  return response;
}

}  // namespace freegs::stages
