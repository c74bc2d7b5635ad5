#include "services/console/answers/json_response.h"

#include "proto/console.pb.h"
#include "services/client/refusal_code.h"
#include "services/job/files/json_text.h"

namespace intaglio::console {
namespace {

std::string CodeOf(int status) {
  switch (status) {
    case 400:
    case 405:
    case 411:
    case 422:
    case 426:
      return ErrorCodeName(ErrorCode::kInvalidValue);
    case 401:
      return "not_logged_in";
    case 404:
      return ErrorCodeName(ErrorCode::kNotFound);
    case 403:
    case 409:
    case 421:
      return ErrorCodeName(ErrorCode::kRefused);
    case 413:
    case 431:
      return ErrorCodeName(ErrorCode::kTooLarge);
    case 429:
      return "too_many_tries";
    case 503:
      return "busy";
    case 504:
      return ErrorCodeName(ErrorCode::kTimedOut);
    default:
      return ErrorCodeName(ErrorCode::kIo);
  }
}

}  // namespace

int StatusOf(ErrorCode code, int otherwise) {
  switch (code) {
    case ErrorCode::kInvalidValue:
      return 400;
    case ErrorCode::kNotFound:
    case ErrorCode::kMissing:
      return 404;
    case ErrorCode::kRefused:
      return 409;
    case ErrorCode::kTooLarge:
      return 413;
    default:
      return otherwise;
  }
}

web::Response JsonResponse(int status, const google::protobuf::Message& message) {
  auto json = JsonTextOf(message);
  if (json) return web::TextResponse(status, "application/json", std::move(*json));
  return web::TextResponse(500, "text/plain; charset=utf-8", json.error().message + "\n");
}

std::string LineOf(const google::protobuf::Message& message) {
  auto json = JsonTextOf(message, JsonLayout::kOneLine);
  return json ? std::move(*json) : std::string();
}

ConsoleError ErrorOf(int status, std::string message) {
  ConsoleError error;
  error.set_message(std::move(message));
  error.set_code(CodeOf(status));
  return error;
}

ConsoleError ErrorOf(const Error& error) {
  ConsoleError answer;
  answer.set_message(error.message);
  answer.set_code(client::RefusalCode(error));
  return answer;
}

web::Response ErrorResponse(int status, std::string message) {
  return JsonResponse(status, ErrorOf(status, std::move(message)));
}

web::Response ErrorResponse(int status, const Error& error) {
  return JsonResponse(status, ErrorOf(error));
}

}  // namespace intaglio::console
