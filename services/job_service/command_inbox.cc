#include "services/job_service/command_inbox.h"

#include <fmt/format.h>

#include <utility>

#include "services/job/mounted/mounted_sample.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/process/log.h"

namespace intaglio::job_service {
namespace {

using bus::Borrow;
using bus::View;

CommandView ViewOf(const intaglio_JobCommand& sample) {
  CommandView command;
  command.sender = View(sample.sender);
  command.number = sample.number;
  command.job_uid = View(sample.job_uid);
  command.epoch = sample.epoch;
  command.kind = sample.kind;
  command.operator_name = View(sample.operator_name);
  command.disarm_count = sample.disarm_count;
  command.from_point = sample.from_point;
  command.fire_uncertain = sample.fire_uncertain;
  command.speed_percent = sample.speed_percent;
  command.accept_breakage = sample.accept_breakage;
  command.basis = sample.basis;
  command.block_id = View(sample.block_id);
  command.cell = View(sample.cell);
  command.before_job_uid = View(sample.before_job_uid);
  command.worker = View(sample.worker);
  if (auto parts = PartsOf(sample.mounted)) {
    command.mounted = std::move(*parts);
  } else {
    command.mount_error = parts.error().message;
  }
  return command;
}

std::string AboutWhat(const CommandView& command) {
  if (command.kind == intaglio_COMMAND_ADMIT) return command.worker;
  return command.job_uid.empty() ? command.cell : "job " + command.job_uid;
}

/// What an arm is based on, for the log.
std::string BasisText(const CommandView& command) {
  switch (command.basis) {
    case intaglio_ARM_BY_PROGRAM:
    case intaglio_ARM_BY_PERSON:
      break;
    case intaglio_ARM_SAME_BLOCK:
      return ", into the block that is in";
    case intaglio_ARM_BY_LOADER:
      return ", with the block " + command.block_id;
  }
  return "";
}

constexpr std::chrono::seconds kLogPeriod{1};

}  // namespace

CommandInbox::CommandInbox(bus::Bus& bus, JobStore& store)
    : store_(store),
      commands_(bus, bus::kJobCommand),
      answers_(bus, bus::kJobCommandAnswer) {}

void CommandInbox::Read(Nanoseconds now) {
  commands_.TakeAll(
      [&](const intaglio_JobCommand& sample, const bus::SampleOrigin& origin) {
        // Its client was answered, gave up waiting, or is gone.
        if (!origin.alive)
          return waiting_.Withdraw(std::string(View(sample.sender)), sample.number);
        const std::string process = origin.writer ? origin.writer->participant : "";
        if (const auto dropped = waiting_.Add(process, ViewOf(sample)))
          Drop(process, *dropped, now);
      });
}

void CommandInbox::Drop(const std::string& process, const CommandView& command,
                        Nanoseconds now) {
  flooder_ = process;
  flooded_at_ = now;
  const std::string why = fmt::format(
      "more than {} commands of its process {} wait for their answers: end "
      "that process, or send the next command when one is answered",
      WaitingCommands::kMaxOfProcess, process);
  if (now >= next_drop_log_) {
    next_drop_log_ = now + kLogPeriod;
    host::LogWarning("a command of {} is dropped: {}", command.sender, why);
  }
  if (drops_answered_ == kDropsAnswered) return;
  ++drops_answered_;
  Publish(command, {intaglio_ANSWER_TOO_MANY, why});
  answered_[process].push_back({command.sender, command.number, now});
}

std::string CommandInbox::Remark(Nanoseconds now) const {
  if (flooder_.empty() || now - flooded_at_ > kFloodStays) return "";
  return fmt::format("the process {} sends more commands than can be answered: end it",
                     flooder_);
}

void CommandInbox::Take(const Decide& decide, Nanoseconds now) {
  drops_answered_ = 0;
  Read(now);
  for (const auto& [process, command] : waiting_.TakeTurn(kDecidedATurn)) {
    Publish(command, AnswerTo(command, decide, now));
    answered_[process].push_back({command.sender, command.number, now});
  }
  DisposeOld(now);
}

CommandAnswer CommandInbox::AnswerTo(const CommandView& command, const Decide& decide,
                                     Nanoseconds now) {
  if (const auto answer = store_.AnswerTo(command.sender, command.number)) return *answer;
  const CommandAnswer answer = decide(command);
  if (answer.code != intaglio_ANSWER_UNKNOWN_JOB) store_.KeepAnswer(command, answer);
  Log(command, answer, now);
  return answer;
}

void CommandInbox::Log(const CommandView& command, const CommandAnswer& answer,
                       Nanoseconds now) {
  if (answer.taken()) {
    return host::LogInfo("{}: command {} of {} is accepted{}", AboutWhat(command),
                         static_cast<int>(command.kind), command.operator_name,
                         BasisText(command));
  }
  if (answer.code == intaglio_ANSWER_UNKNOWN_JOB) {
    if (now < next_unknown_log_) return;
    next_unknown_log_ = now + kLogPeriod;
  }
  host::LogWarning("{}: command {} of {} is refused: {}", AboutWhat(command),
                   static_cast<int>(command.kind), command.operator_name, answer.message);
}

void CommandInbox::Publish(const CommandView& command, const CommandAnswer& answer) {
  intaglio_JobCommandAnswer sample{};
  sample.sender = Borrow(command.sender);
  sample.number = command.number;
  sample.job_uid = Borrow(command.job_uid);
  sample.code = answer.code;
  sample.message = Borrow(answer.message);
  if (auto written = answers_.Write(sample); !written) {
    host::LogWarning("answer to command {} of {}: {}", command.number, command.sender,
                     written.error().message);
  }
}

void CommandInbox::DisposeOld(Nanoseconds now) {
  const std::string empty;
  for (auto& [process, answered] : answered_) {
    while (!answered.empty() &&
           (now - answered.front().at > kAnswerStays || answered.size() > kMaxAnswers)) {
      intaglio_JobCommandAnswer sample{};
      sample.sender = Borrow(answered.front().sender);
      sample.number = answered.front().number;
      sample.job_uid = sample.message = Borrow(empty);
      (void)answers_.Dispose(sample);
      answered.pop_front();
    }
  }
  std::erase_if(answered_, [](const auto& entry) { return entry.second.empty(); });
}

}  // namespace intaglio::job_service
