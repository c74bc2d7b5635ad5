#pragma once

#include <string>

#include "engrave/core/result.h"
#include "proto/console.pb.h"
#include "services/platform/web/server.h"

namespace intaglio::console {

/// 500 when a text in it is not UTF-8.
web::Response JsonResponse(int status, const google::protobuf::Message& message);

/// One line; "" when a text in it is not UTF-8.
std::string LineOf(const google::protobuf::Message& message);

/// The status of HTTP for what was not done; `otherwise`: of what the table does not
/// have.
int StatusOf(ErrorCode code, int otherwise = 500);

/// With the code of the status of HTTP.
ConsoleError ErrorOf(int status, std::string message);
/// With the code of the error (services/client/refusal_code.h).
ConsoleError ErrorOf(const Error& error);

web::Response ErrorResponse(int status, std::string message);
web::Response ErrorResponse(int status, const Error& error);

}  // namespace intaglio::console
