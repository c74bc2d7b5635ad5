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
// PAUSE and CANCEL are decided first of the commands of a turn; otherwise the commands of
// one sender are decided in their order. A turn decides kDecidedATurn at most, of every
// process its share (waiting_commands.h).
//
// A command about a job that does not exist is answered and not kept: it changes nothing,
// whenever it is delivered again. Of a process that sends more than are decided the
// newest are dropped, and answered with TOO_MANY: kDropsAnswered a turn, so that a flood
// delays nobody else; a client that is not answered ends its wait by itself
// (JobClient::kAnswerTime). Used from one thread.

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>

#include "services/job_service/job_store.h"
#include "services/job_service/queue/job_queue.h"
#include "services/job_service/waiting_commands.h"
#include "services/platform/bus/bus.h"

namespace intaglio::job_service {

class CommandInbox {
 public:
  using Decide = std::function<CommandAnswer(const CommandView& command)>;
  /// Longer than any client waits, also for one that has not found the answers' writer
  /// yet.
  static constexpr std::chrono::seconds kAnswerStays{60};
  /// Each is a commit on the disk, of some milliseconds; a turn may not last long.
  static constexpr std::size_t kDecidedATurn = 32;
  /// Answers to one process that stay on the bus, the newest.
  static constexpr std::size_t kMaxAnswers = 1024;
  static constexpr std::size_t kDropsAnswered = 64;
  /// A flood is over when nothing was dropped for so long.
  static constexpr std::chrono::seconds kFloodStays{10};

  CommandInbox(bus::Bus& bus, JobStore& store);

  /// Reads what has come; decides and answers what is in turn.
  void Take(const Decide& decide, Nanoseconds now);

  /// What a person has to do about a process that floods; empty: nothing.
  std::string Remark(Nanoseconds now) const;

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
  void Read(Nanoseconds now);
  void Drop(const std::string& process, const CommandView& command, Nanoseconds now);
  CommandAnswer AnswerTo(const CommandView& command, const Decide& decide,
                         Nanoseconds now);
  void Log(const CommandView& command, const CommandAnswer& answer, Nanoseconds now);
  void Publish(const CommandView& command, const CommandAnswer& answer);
  void DisposeOld(Nanoseconds now);

  JobStore& store_;
  bus::Reader<intaglio_JobCommand> commands_;
  bus::Writer<intaglio_JobCommandAnswer> answers_;
  WaitingCommands waiting_;
  std::map<std::string, std::deque<Answered>> answered_;  // by process, the oldest first
  // Logs of a flood are written once a second at most.
  Nanoseconds next_drop_log_{0}, next_unknown_log_{0};
  std::size_t drops_answered_ = 0;  // in this turn
  std::string flooder_;             // the process whose command was dropped last
  Nanoseconds flooded_at_{0};
};

}  // namespace intaglio::job_service
