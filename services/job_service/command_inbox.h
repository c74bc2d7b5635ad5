#pragma once

// The commands of all clients and the answers to them. Every command gets one answer, and
// is applied once: it is stored with its answer, so that a command that is delivered
// again, by a network or to the next life of the job service, is answered again and not
// applied.
//
//   command --new----------------> decide --> kept --> answered --60 s--> disposed
//      |-----answered before-----------------------------^
//      +--withdrawn by its client before it was read: ARM, RESUME, SPEED are dropped
//
// PAUSE and CANCEL are decided first of commands that are read together; otherwise the
// commands of one sender are decided in their order. Used from one thread.

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>

#include "services/job_service/job_store.h"
#include "services/job_service/queue/job_queue.h"
#include "services/platform/bus/bus.h"

namespace intaglio::job_service {

class CommandInbox {
 public:
  using Decide = std::function<CommandAnswer(const CommandView& command)>;
  /// Longer than any client waits, also for one that has not found the answers' writer
  /// yet.
  static constexpr std::chrono::seconds kAnswerStays{60};

  CommandInbox(bus::Bus& bus, JobStore& store);

  /// Decides and answers what has come.
  void Take(const Decide& decide, Nanoseconds now);

  template <typename Loop>
  void AttachTo(Loop& loop) {
    loop.Attach(commands_);
  }

 private:
  struct Answered {
    std::string sender;
    std::uint64_t number;
    Nanoseconds at;
  };
  CommandAnswer AnswerTo(const CommandView& command, const Decide& decide);
  void Publish(const CommandView& command, const CommandAnswer& answer);
  void DisposeOld(Nanoseconds now);

  JobStore& store_;
  bus::Reader<intaglio_JobCommand> commands_;
  bus::Writer<intaglio_JobCommandAnswer> answers_;
  std::deque<Answered> answered_;  // the oldest first
};

}  // namespace intaglio::job_service
