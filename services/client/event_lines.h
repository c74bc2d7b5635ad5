#pragma once

// --events: what happens to jobs as lines of JSON for programs, one JobEvent
// (proto/shop.proto) a line; docs/cli.md describes each field.

#include <chrono>
#include <functional>
#include <iosfwd>
#include <map>
#include <string>

#include "proto/shop.pb.h"
#include "services/client/job_client.h"
#include "services/job/verdict/verdict.h"

namespace intaglio::client {

/// What became of a job that has ended.
struct JobEnd {
  ShopVerdict verdict;
  intaglio_PointCounts counts{};  ///< zeros when the engraving never began
};

/// The job service has published its end with its verdict: its counts are settled.
inline bool IsSettled(const JobView& job) { return job.ended() && !job.verdict.empty(); }
/// In which a job service settles an end (patience.h), also of a machine that is silent.
inline constexpr std::chrono::seconds kSettledWithin{15};

/// Verdict and counts as in the history: polls until the job service has settled them,
/// for kSettledWithin at most; then by what the synchronizer has reported.
JobEnd EndOf(JobClient& client, const JobView& job);

class EventLines {
 public:
  using Clock = std::function<std::chrono::system_clock::time_point()>;
  explicit EventLines(std::ostream& out, Clock clock = std::chrono::system_clock::now);

  void Submitted(const JobView& job, const std::string& id = {});
  /// Lines for what is new since the last call: the warnings, the state, the message, and
  /// progress at most every kPeriod.
  void Show(const JobView& job, const std::string& id = {});
  void Ended(const JobView& job, const JobEnd& end, const std::string& id = {});
  /// Any other; the time is filled in.
  void Write(JobEvent event);

  static constexpr std::chrono::milliseconds kPeriod{500};

 private:
  struct Shown {
    std::string state, message, alarm, pause_reason;
    std::uint32_t stage = 0, done = 0, total = 0;
    bool armed = false;
    Warnings warnings;
    std::chrono::system_clock::time_point at;
  };
  std::ostream& out_;
  Clock clock_;
  std::map<std::string, Shown> shown_;  // by uid
};

/// The fields that a JobStatus has.
JobEvent EventOf(const char* event, const JobView& job, const std::string& id);

/// The exit code for a block that was engraved: 0 good, also with warnings, else 3.
int ExitCodeOf(VerdictKind verdict);
/// 0 done and good, 3 not good or not known, 4 failed, 5 cancelled (docs/cli.md).
int ExitCodeOf(const JobView& job, const ShopVerdict& verdict);

}  // namespace intaglio::client
