#pragma once

// The life of a worker of one stage, the same for all: it is given a task, takes its
// input under credit, computes in a thread of its own while the bus loop keeps the health
// fresh, hands the points to its consumer under credit, and reports the result.
//
//   idle -> taking input -> computing -> made -> sending -> idle
//
// Another part of the chain that is at work waits for its turn: it computes while the one
// before it is sent, so that a core never waits for the bus. At most one that is made
// waits behind the one that is sent, which bounds the memory. Any other task takes the
// place of all.
//
// A task that is revoked, or superseded, or whose job service has died is cancelled at
// once; a computation that still runs is waited for without blocking the loop. A
// revocation cancels the whole chain of parts: one sample a worker is retained, so one
// for each part could be missed. An error ends its task alone (TASK_FAILED), never the
// process.
//
// Every turn takes all samples that have come from input and output, wanted or not: bulk
// topics carry the streams of all workers, and samples that are not taken would
// accumulate and end every wait.

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "services/platform/host/process/service_host.h"
#include "services/platform/host/stage/stage_task.h"
#include "services/platform/host/stage/task_reporter.h"
#include "services/platform/host/threads/computation.h"

namespace intaglio::host {

/// Where a stage's input comes from and what is computed from it.
class StageInput {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  virtual ~StageInput() = default;
  virtual Status Open(const StageTask& task) = 0;
  /// Takes what has come and drops what is not of the open task, also when none is open;
  /// true when all of its input is there. Once a turn. Never blocks.
  virtual Result<bool> Poll(TimePoint now) = 0;
  /// The task is computed or has ended, `withdrawn` when before its time: its job is not
  /// asked for again. The next one may be opened.
  virtual void Close(bool withdrawn, TimePoint now) = 0;
  /// Moves the input into a function that needs nothing else and runs in another thread.
  virtual Computation<StageResult>::Function TakeComputation(const StageTask& task) = 0;
  /// Machining time of the job as the computation taken last has estimated it; 0: not
  /// yet.
  virtual std::uint64_t estimate_ticks() const { return 0; }
};

/// Where the points or marks go.
class StageOutput {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  virtual ~StageOutput() = default;
  virtual void Begin(const StageTask& task, StageResult result, TimePoint now) = 0;
  /// Takes the credit that has come and sends what may be sent; true when the consumer
  /// has everything, or nothing is to be sent. Once a turn. Never blocks.
  virtual Result<bool> Advance(TimePoint now) = 0;
  virtual void End() = 0;
};

class StageWorker {
 public:
  using TimePoint = StageOutput::TimePoint;
  /// `wake` ends the loop's wait; it is called from the computing thread.
  StageWorker(ServiceHost& host, const bus::Topic<intaglio_StageTask>& tasks,
              intaglio_Stage stage, StageInput& input, StageOutput& output,
              std::function<void()> wake);
  ~StageWorker();

  /// One turn of the loop. Never blocks.
  void Turn(TimePoint now);
  /// Fails the running task; the service is about to end.
  void Stop();
  bus::Reader<intaglio_StageTask>& tasks() { return tasks_; }

 private:
  enum class Phase { kWaiting, kInput, kComputing, kMade, kSending };

  /// A task from its acceptance to its end.
  struct Work {
    StageTask task;          // its job when it begins
    std::string frozen_job;  // serialized, until then
    Phase phase = Phase::kWaiting;
    StageResult result;  // when it is made
    TaskProgress progress;
    TimePoint began_at{}, reported_at{};
  };

  void TakeTasks();
  void Receive(const intaglio_StageTask& sample);
  void Revoke(const StageTask& task);
  void Withdraw(ErrorCode code, const std::string& reason);
  void Accept(Work work);
  void Advance();
  void EndWithdrawn();
  /// Goes on with the first part that is not made yet; false: there is nothing to go on
  /// with. `taken` is the last result of its input.
  bool Make(Result<bool>& taken);
  Result<bool> MakeOne(Work& work, Result<bool>& taken);
  Status Begin(Work& work);
  Status FinishComputing(Work& work);
  /// The first is sent when it is made; false: as above.
  bool Send(const Result<bool>& sent);
  void Report(Work& work);
  /// Without an error: it is done.
  void End(std::size_t place, const Error* error);

  ServiceHost& host_;
  bus::Reader<intaglio_StageTask> tasks_;
  TaskReporter reporter_;
  StageInput& input_;
  StageOutput& output_;
  std::function<void()> wake_;

  std::deque<Work> works_;           // in the order of their making and sending
  std::optional<Work> pending_;      // begins when all of these have ended
  std::optional<StageTask> newest_;  // given last; received again when a link is back
  std::unique_ptr<Computation<StageResult>> computation_;
  std::optional<Error> withdrawn_;
  TimePoint now_{};
};

/// Runs the worker on the wait set until the host is to stop. The wait set has the
/// readers of input and output attached. The calling thread gives way (worker_threads.h),
/// for it sends and receives what was computed; the threads of the bus do not.
int RunStageWorker(ServiceHost& host, bus::WaitSet& wait, StageWorker& worker);

}  // namespace intaglio::host
