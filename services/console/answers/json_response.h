#pragma once

#include <string>

#include "services/platform/web/server.h"

namespace google::protobuf {
class Message;
}

namespace intaglio::console {

/// 500 when a text in it is not UTF-8.
web::Response JsonResponse(int status, const google::protobuf::Message& message);

/// One line; "" when a text in it is not UTF-8.
std::string LineOf(const google::protobuf::Message& message);

/// A ConsoleError.
web::Response ErrorResponse(int status, std::string message);

}  // namespace intaglio::console
