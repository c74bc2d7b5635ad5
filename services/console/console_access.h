#pragma once

// Who uses the console, and what each may do. One person is in charge: only the commands
// of that person are taken. Charge is with the first operator who sends a command, until
// somebody takes over, which everybody sees, or the person is no longer logged in.
//
// Whoever has the key of the printed address is an operator named kKeyName.

#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "proto/console.pb.h"
#include "services/console/routes.h"
#include "services/platform/access/log_ins.h"
#include "services/platform/web/server.h"

namespace intaglio::console {

/// No name of a user: it has a space.
inline constexpr char kKeyName[] = "this computer";

struct Visitor {
  std::string session, name;
  access::UserRole role = access::UserRole::kObserver;
  bool rests = false;  ///< an operator who did nothing for 30 minutes: looks alone
};

/// Why a request is refused.
struct Refusal {
  int status;        ///< of HTTP
  std::string code;  ///< not_operator, resting, not_in_charge
  std::string message;
};

/// From any thread.
class ConsoleAccess {
 public:
  using Clock = std::chrono::steady_clock;
  explicit ConsoleAccess(std::filesystem::path users_file) : log_ins_(users_file) {}

  access::LogIns& log_ins() { return log_ins_; }
  /// nullopt: nobody is logged in there (any more).
  std::optional<Visitor> VisitorOf(const web::Caller& caller) const;
  /// nullopt: the visitor has the right; of kCharge, is in charge from now on.
  std::optional<Refusal> WhyNot(Right right, const Visitor& visitor);
  void TakeCharge(const Visitor& visitor);
  /// Empty: nobody.
  std::string InCharge() const;
  ConsoleSession SessionOf(const Visitor& visitor) const;
  /// The sessions that ended since the last call.
  std::vector<std::string> TakeEnded(Clock::time_point now);

 private:
  access::LogIns log_ins_;
  mutable std::mutex mutex_;
  std::string in_charge_;
};

}  // namespace intaglio::console
