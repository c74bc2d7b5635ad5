#pragma once

// The requests below /api/v1/machines: what there is to teach at a machine, test pulses
// and focus series. What moves, lights or saves something goes over the WebSocket
// (jog_desk.h), while a person holds a button; a test job fires when it is armed.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "services/client/teach/stage_per_glass.h"
#include "services/console/answers/find_job.h"
#include "services/console/answers/work_queue.h"
#include "services/console/submit/submit_api.h"
#include "services/console/teach/jog_desk.h"
#include "services/platform/web/server.h"

namespace intaglio::console {

inline constexpr char kMachinesPath[] = "/api/v1/machines/";

/// "els-03" and "teaching" of "/api/v1/machines/els-03/teaching"; nullopt: another path.
struct MachinePath {
  std::string cell, part;
};
std::optional<MachinePath> SplitMachinePath(std::string_view path);

/// In the server's thread; disks and processes have threads of their own.
class TeachApi {
 public:
  /// `materials`: material base, empty: the user's. All live longer.
  TeachApi(const JogDesk& jogs, SubmitApi& submit, FindJob find_job,
           const std::string& materials)
      : jogs_(jogs),
        submit_(submit),
        find_job_(std::move(find_job)),
        stage_per_glass_(client::StagePerGlassOf(materials)) {}

  void Answer(const MachinePath& path, const web::Request& request, web::Reply reply);

 private:
  void Submit(const client::MachineView& machine, const std::string& part,
              const web::Request& request, web::Reply reply);
  void AnswerZeroMove(const client::MachineView& machine, const web::Request& request,
                      web::Reply reply);
  void Read(std::function<void()> work, const web::Reply& reply);

  const JogDesk& jogs_;
  SubmitApi& submit_;
  FindJob find_job_;
  client::StagePerGlass stage_per_glass_;
  WorkQueue disk_{16};
};

}  // namespace intaglio::console
