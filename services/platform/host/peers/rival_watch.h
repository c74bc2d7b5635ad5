#pragma once

// Whether another process already does what this one is about to do. Pure: received
// health goes in, a verdict comes out.
//
//   starting:  a rival that works                 -> kEnd
//              a rival that starts, too           -> kEnd for the greater instance name
//              a rival that ends, or was received only once (it may be dead: its last
//              sample outlives it)                -> kWait, until it is silent for kStale
//              none, for the time of `period`       -> kGoOn
//   working:   a rival that works, too            -> kEnd for the greater instance name
//
// So of two that start at once one stays, also when only one of them sees the other.
// Where another lock has decided already who goes on (a store's), those that start stand
// by and are no rivals.

#include <chrono>
#include <map>
#include <string>

#include "idl/service.h"

namespace intaglio::host {

struct Rival {
  std::string instance;
  std::string host;
  std::int32_t pid = 0;
  intaglio_HealthState state = intaglio_HEALTH_STARTING;
};

class RivalWatch {
 public:
  using Nanoseconds = std::chrono::nanoseconds;
  enum class Verdict { kGoOn, kWait, kEnd };
  /// Health comes every 600 ms, and the lease of a dead process lasts as long.
  static constexpr std::chrono::milliseconds kStale{1500};

  enum class Starting { kIsRival, kWaits };

  /// `period`: for how long no rival may be received before this one goes on.
  RivalWatch(std::string own_instance, Nanoseconds began, Nanoseconds period,
             Starting starting = Starting::kIsRival)
      : own_instance_(std::move(own_instance)),
        began_(began),
        period_(period),
        starting_(starting) {}

  void Receive(const Rival& rival, Nanoseconds now);
  void Lose(const std::string& instance) { received_.erase(instance); }

  Verdict JudgeStart(Nanoseconds now);
  /// kGoOn or kEnd.
  Verdict JudgeWork(Nanoseconds now);
  /// The rival of the last kEnd.
  const Rival& rival() const { return rival_; }

 private:
  struct Received {
    Rival rival;
    int count = 0;
    Nanoseconds last{0};
  };
  bool IsStale(const Received& received, Nanoseconds now) const {
    return now - received.last > kStale;
  }

  std::string own_instance_;
  Nanoseconds began_, period_;
  Starting starting_;
  std::map<std::string, Received> received_;
  Rival rival_;
};

}  // namespace intaglio::host
