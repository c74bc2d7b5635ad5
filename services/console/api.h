#pragma once

// What the web server of the console asks the shop for: /api/v1, /metrics and the
// WebSocket /control. docs/console.md describes each path.

#include <filesystem>
#include <memory>
#include <string>

#include "services/console/cloud_reader.h"
#include "services/console/shop_desk.h"
#include "services/platform/web/server.h"

namespace intaglio::console {

inline constexpr char kEventsPath[] = "/api/v1/events";
inline constexpr char kControlPath[] = "/control";

class Api {
 public:
  /// All live longer.
  Api(ShopDesk& desk, CloudReader& clouds) : desk_(desk), clouds_(clouds) {}

  // In the server's thread.
  void Answer(const web::Request& request, web::Reply reply);
  /// The answer to a text from the WebSocket, in one line of JSON.
  std::string AnswerMessage(const std::string& text);

 private:
  void AnswerGet(const std::string& path, const web::Request& request, web::Reply reply);
  void AnswerPost(const std::string& path, const web::Request& request, web::Reply reply);
  void AnswerJob(const std::string& job, const std::string& part, std::uint32_t from,
                 web::Reply reply);

  ShopDesk& desk_;
  CloudReader& clouds_;
};

/// What a page asks for on the WebSocket. kInvalidValue: it is no ConsoleRequest.
Result<ConsoleRequest> ParseConsoleRequest(const std::string& text);

}  // namespace intaglio::console
