#pragma once

// The requests of the console: one row each. The API takes from it who may send what, and
// the OpenAPI file what is asked and answered.

#include <span>
#include <string>
#include <string_view>

namespace intaglio::console {

/// Who may send a request.
enum class Right {
  kOpen,     ///< anybody: the log-in
  kRead,     ///< who is logged in, an observer too: to read, and to stop
  kOperate,  ///< an operator
  kCharge,   ///< the operator in charge
};

struct Route {
  std::string_view method;
  /// A name in braces is any one part of it: {job} a number or a uid.
  std::string_view path;
  Right right;
  std::string_view request;  ///< message of the body, or a media type; empty: none
  std::string_view answer;   ///< message, or a media type
  std::string_view purpose;
};

std::span<const Route> Routes();
/// Null: there is no such request.
const Route* FindRoute(std::string_view method, std::string_view path);

/// The methods of a path, "GET, POST"; empty: there is nothing at it.
std::string MethodsOf(std::string_view path);

}  // namespace intaglio::console
