#pragma once

// Which job of a batch goes to which machine next: pure decisions.
//
//   kWaiting --Next--> kOut --Ended--> kGood, kBad
//      |  a job that it comes after is bad
//      +---------------------------------------> kSkipped
//   Stop leaves what is kWaiting as it is.

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace intaglio::cli {

/// A job, by its place in the batch.
struct PlannedJob {
  std::vector<std::size_t> after;  ///< no circles
  std::int32_t priority = 0;
  std::vector<std::string> cells;  ///< which of them can make it; one or more
};

class BatchPlan {
 public:
  enum class State { kWaiting, kOut, kGood, kBad, kSkipped };
  struct Start {
    std::size_t job;
    std::string cell;
  };

  /// `parallel` jobs at most are out, on each machine its share of them, rounded up;
  /// 0: as many as there are machines.
  BatchPlan(std::vector<PlannedJob> jobs, std::size_t parallel);

  /// Jobs that may begin now, higher priorities first, then in the order of the batch,
  /// each on the machine that has the least to do. They are out from now on.
  std::vector<Start> Next();
  /// Returns those that are skipped because of it.
  std::vector<std::size_t> Ended(std::size_t job, bool good);
  /// Nothing begins any more.
  void Stop() { stopped_ = true; }

  State state(std::size_t job) const { return states_.at(job); }
  std::size_t count(State state) const;
  /// Nothing is out and nothing will be.
  bool over() const;

 private:
  bool MayBegin(std::size_t job) const;
  /// The machine for it, or none.
  const std::string* FreeCell(std::size_t job) const;

  std::vector<PlannedJob> jobs_;
  std::vector<State> states_;
  std::vector<std::size_t> order_;  // by priority
  std::map<std::size_t, std::string> cell_of_;
  std::map<std::string, std::size_t> out_;  // by machine
  std::size_t parallel_, share_;
  bool stopped_ = false;
};

}  // namespace intaglio::cli
