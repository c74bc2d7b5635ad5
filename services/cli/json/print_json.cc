#include "services/cli/json/print_json.h"

#include <iostream>

#include "services/cli/terminal/complain.h"
#include "services/job/files/json_text.h"

namespace intaglio::cli {

int PrintJson(const google::protobuf::Message& message) {
  const auto json = JsonTextOf(message);
  if (!json) return Complain(json.error());
  std::cout << *json << std::flush;
  return client::kExitGood;
}

}  // namespace intaglio::cli
