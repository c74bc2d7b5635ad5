#pragma once

// The console's side of the bus: follows a shop, sends commands about jobs, and collects
// what confirms a stop. One thread turns it; orders of the web server come by a queue.

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "proto/console.pb.h"
#include "services/client/event_lines.h"
#include "services/client/shop/shop_snapshot.h"
#include "services/client/shop/shop_stops.h"
#include "services/client/shop/stop_reset.h"
#include "services/console/arm_holds.h"
#include "services/console/shop_metrics.h"

namespace intaglio::console {

class ShopDesk {
 public:
  using Clock = std::chrono::steady_clock;
  explicit ShopDesk(bus::Bus& bus);

  // From any thread.

  /// Sends the emergency stop to every machine; on the bus when this returns.
  StopAnswer Press(const std::string& reason);
  /// To be done with the shop in the desk's next turn.
  void Order(std::function<void(ShopDesk&)> order);

  // From the thread that turns it.

  /// Waits up to 20 ms for news, 2 ms while something waits for an answer, after a turn
  /// with orders, or `in_haste`; then does the orders.
  void Turn(bool in_haste = false);
  /// The lines of --events since the last call.
  std::vector<std::string> TakeEvents();
  ConsoleState State();
  ShopStatus Status() const;
  std::string Metrics() const { return metrics_.Text(); }
  client::JobClient& client() { return watcher_.client(); }
  bool IsComplete() const { return watcher_.IsComplete(); }

  using Answer = std::function<void(int status, const CommandAnswer&)>;
  /// A person who reads `block` as mounted begins to hold (arm_holds.h): 200 held,
  /// 404 no such job, 409 refused.
  std::pair<int, HoldAnswer> Hold(const std::string& job, const std::string& block);
  /// Nothing that is held counts any more: another person is in charge.
  void LetGo() { holds_.LetGo(); }
  /// Pause, cancel or speed. The answer comes in a later turn: 200 taken, 404 no such
  /// job, 409 refused, 503 not sent, 504 no answer in time (it is withdrawn then).
  void Command(const std::string& job, const client::JobOrder& order, Answer answer);
  /// Arm or resume, at the end of the hold with this token; answers as Command.
  void Fire(const std::string& job, const std::string& token, client::JobOrder order,
            Answer answer);
  /// Releases those of `presses`, texts of MachineStatus.stops_held, that the machine
  /// holds; none: the stop that its own controller keeps latched. Answers as Command; 409
  /// also when it holds none of them.
  void Reset(const std::string& cell, const std::set<std::string>& presses,
             const std::string& person, Answer answer);
  /// `answer` gets the confirmations of the press when every machine has confirmed it, or
  /// after a second.
  void AwaitConfirmation(std::uint32_t number,
                         std::function<void(const StopAnswer&)> answer);
  /// What the machines report of the last press.
  StopAnswer Confirmations();
  /// Every machine has confirmed the last press, and no State has said so yet.
  bool IsConfirmedAnew();

 private:
  struct PendingCommand {
    std::uint64_t number;
    CommandAnswer answer;
    Clock::time_point end;
    Answer reply;
  };
  struct PendingReset {
    std::string cell;
    std::unique_ptr<client::StopReset> reset;
    Clock::time_point end;
    Answer reply;
  };
  struct PendingStop {
    Clock::time_point end;
    std::function<void(const StopAnswer&)> reply;
  };
  /// The job that may be commanded; nullopt: it may not, and that is answered.
  std::optional<client::JobView> OpenJobNamed(const std::string& name,
                                              const Answer& answer);
  void Send(const client::JobView& job, const client::JobOrder& order, Answer answer);
  void AnswerCommands();
  void AnswerStops();
  void AnswerResets();
  bool IsAwaited() {
    return !commands_.empty() || !stops_.empty() || !resets_.empty() || IsStopAwaited();
  }
  /// A press of the last second that no State has shown as confirmed.
  bool IsStopAwaited();

  bus::Bus& bus_;
  client::ShopWatcher watcher_;
  client::MachineReports reports_;
  std::ostringstream lines_;
  client::EventLines events_{lines_};
  bool knows_jobs_ = false;            ///< those that had ended before are known
  std::map<std::string, bool> ended_;  ///< by uid: its end is known, or was before
  ArmHolds holds_;
  ShopMetrics metrics_;
  std::vector<PendingCommand> commands_;
  std::vector<PendingStop> stops_;
  std::vector<PendingReset> resets_;
  std::uint32_t shown_confirmed_ =
      0;                         ///< number of the last press that a State confirmed
  bool has_had_orders_ = false;  // in the last turn: more will follow

  std::mutex mutex_;  // of what follows
  client::StopSource source_;
  std::uint32_t pressed_ = 0;  ///< number of the last press; 0: none
  Clock::time_point pressed_at_;
  std::vector<std::function<void(ShopDesk&)>> orders_;
};

}  // namespace intaglio::console
