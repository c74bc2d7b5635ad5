#pragma once

// The proofs of a shop's jobs: when a job of the cell has ended, a separate process
// (`intaglio verify`), which gives way to all others, completes its folder with
// report.json, views.png and customer.png. Neither the job service nor the machine waits
// for it, and what crashes it does nothing else. A folder that cannot be completed, as of
// a full disk, is tried again. Used from one thread.

#include <chrono>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "proto/report.pb.h"
#include "services/client/child_process.h"
#include "services/client/job_client.h"

namespace intaglio::client {

struct ShopProofOptions {
  std::filesystem::path folder;        ///< of the shop: glass records, proof.log
  std::string cell;                    ///< whose jobs; others are in other folders
  std::filesystem::path program;       ///< intaglio
  std::vector<std::string> arguments;  ///< further ones of `intaglio verify`
};

/// What is known of the shop.
struct ShopView {
  const std::map<std::string, JobView>& jobs;  ///< by uid
  std::function<JobStages(const JobView&)> stages;
  bool has_job_service = false;  ///< If not, jobs may be missing.
};
ShopView ViewOf(const JobClient& client);

class ShopProofs {
 public:
  using Clock = std::chrono::steady_clock;
  explicit ShopProofs(ShopProofOptions options) : options_(std::move(options)) {}

  /// Takes the jobs that have ended, starts the next process, and takes the end of the
  /// last. Never waits. Returns what a person should know, a sentence each.
  std::vector<std::string> Turn(const ShopView& shop, Clock::time_point now);
  /// Jobs whose folders are not complete yet, but for those that have to be tried again.
  std::size_t pending_count() const;
  /// A process is running.
  bool at_work() const { return process_ != nullptr; }

  /// For an outcome that comes after the end of its job.
  static constexpr std::chrono::seconds kOutcomeTime{5};
  static constexpr std::chrono::seconds kFirstRetry{30};
  static constexpr std::chrono::seconds kLastRetry{1800};

 private:
  struct Pending {
    JobView job;
    Clock::time_point ended_at, not_before;
    std::chrono::seconds retry = kFirstRetry;
    std::string reported;  ///< the last error, reported once
  };
  void Receive(const ShopView& shop, Clock::time_point now);
  void Start(const ShopView& shop, Clock::time_point now);
  void TakeEnd(Clock::time_point now, std::vector<std::string>& sentences);
  void Retry(Clock::time_point now, const std::string& error,
             std::vector<std::string>& sentences);
  void RemoveOldGlass(const ShopView& shop, Clock::time_point now);

  ShopProofOptions options_;
  std::set<std::string> seen_;  ///< ended jobs, by uid
  std::deque<Pending> pending_;
  std::optional<Pending> proved_;  ///< by the process
  std::unique_ptr<ChildProcess> process_;
  std::string not_started_;  ///< why there is no process
  std::optional<Clock::time_point> began_;
  bool old_glass_removed_ = false;
};

}  // namespace intaglio::client
