#include "services/console/answers/json_response.h"

#include "proto/console.pb.h"
#include "services/job/files/json_text.h"

namespace intaglio::console {

web::Response JsonResponse(int status, const google::protobuf::Message& message) {
  auto json = JsonTextOf(message);
  if (json) return web::TextResponse(status, "application/json", std::move(*json));
  return web::TextResponse(500, "text/plain; charset=utf-8", json.error().message + "\n");
}

std::string LineOf(const google::protobuf::Message& message) {
  auto json = JsonTextOf(message, JsonLayout::kOneLine);
  return json ? std::move(*json) : std::string();
}

web::Response ErrorResponse(int status, std::string message) {
  ConsoleError error;
  error.set_message(std::move(message));
  return JsonResponse(status, error);
}

}  // namespace intaglio::console
