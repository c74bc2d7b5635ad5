#pragma once

// Who is logged in to a console.
//
//   LogIn      name and password -> token, 256 bits at random; kept as its hash alone
//   Find       token -> session; a use of it
//   Act        the person does something
//   rests      idle_time after the last act: it has the role observer until the next
//              log-in, so that a page that is only looked at stays, and commands nothing
//   ends       by LogOut; idle_time after the last use; whole_time after the log-in; when
//              the user is no longer in the file, or with another role or password
//
// Wrong passwords: after `free_failures` of a name, or from an address, each further one
// makes the next try wait twice as long, 1 s to max_wait. A try in that time is not
// checked, the right password neither. They are forgotten forget_time after the last.
//
// From any thread; LogIn takes some 30 ms.

#include <chrono>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "services/platform/access/users.h"

namespace intaglio::access {

struct LogInLimits {
  std::chrono::seconds idle_time{30 * 60};
  std::chrono::seconds whole_time{12 * 60 * 60};
  int free_failures = 10;
  std::chrono::seconds max_wait{60};
  std::chrono::seconds forget_time{15 * 60};
  std::size_t session_count = 64;  ///< then the one that was used longest ago ends
};

struct Session {
  std::string id;  ///< the hash of its token
  std::string name;
  UserRole role = UserRole::kObserver;
  bool rests = false;  ///< an operator who has done nothing for idle_time
};

class LogIns {
 public:
  using Clock = std::chrono::steady_clock;
  explicit LogIns(std::filesystem::path users_file, LogInLimits limits = {});

  struct Opened {
    std::string token;
    Session session;
  };
  /// kRefused: a wrong name or password, which are not told
  /// apart. kTimedOut: too many were wrong; the sentence has the time to wait. Another
  /// code: what ReadUsers returns.
  Result<Opened> LogIn(const std::string& name, const std::string& password,
                       const std::string& address, Clock::time_point now);
  std::optional<Session> Find(const std::string& token, Clock::time_point now);
  /// By its id; no use of it.
  std::optional<Session> At(const std::string& id, Clock::time_point now) const;
  /// Of a session that does not rest.
  void Act(const std::string& id, Clock::time_point now);
  void LogOut(const std::string& id);
  /// Somebody of this name is logged in, and does not rest.
  bool IsHere(const std::string& name, Clock::time_point now) const;
  /// Ends what is over by now, or by the file; the ids of all that ended since the last
  /// call.
  std::vector<std::string> TakeEnded(Clock::time_point now);

 private:
  struct Open {
    Session session;
    std::string hash;  // of the password then
    Clock::time_point opened, used, acted;
  };
  struct Failures {
    int count = 0;
    Clock::time_point last, next;
  };
  Session SessionOf(const Open& open, Clock::time_point now) const;
  void EndBy(const std::vector<User>& users);
  void End(std::map<std::string, Open>::iterator session);
  void CountFailure(const std::string& key, Clock::time_point now);
  std::chrono::seconds WaitOf(const std::string& key, Clock::time_point now) const;
  Opened Start(const User& user, Clock::time_point now);

  const std::filesystem::path users_file_;
  const LogInLimits limits_;
  mutable std::mutex mutex_;  // of what follows
  std::filesystem::file_time_type users_read_{};
  std::map<std::string, Open> sessions_;  // by id
  std::map<std::string, Failures> failures_;
  std::vector<std::string> ended_;
};

}  // namespace intaglio::access
