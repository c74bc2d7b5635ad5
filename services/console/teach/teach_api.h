#pragma once

// The requests below /api/v1/machines: what there is to teach at a machine. What moves,
// lights or saves something goes over the WebSocket (jog_desk.h), while a person holds a
// button.

#include <optional>
#include <string>
#include <string_view>

#include "services/console/answers/work_queue.h"
#include "services/console/teach/jog_desk.h"
#include "services/platform/web/server.h"

namespace intaglio::console {

inline constexpr char kMachinesPath[] = "/api/v1/machines/";

/// "els-03" and "teaching" of "/api/v1/machines/els-03/teaching"; nullopt: another path.
struct MachinePath {
  std::string cell, part;
};
std::optional<MachinePath> SplitMachinePath(std::string_view path);

/// In the server's thread; disks have a thread of their own.
class TeachApi {
 public:
  explicit TeachApi(const JogDesk& jogs) : jogs_(jogs) {}

  void Answer(const MachinePath& path, web::Reply reply);

 private:
  const JogDesk& jogs_;
  WorkQueue disk_{16};
};

}  // namespace intaglio::console
