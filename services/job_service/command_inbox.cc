#include "services/job_service/command_inbox.h"

#include <algorithm>
#include <tuple>
#include <utility>
#include <vector>

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
  if (auto parts = PartsOf(sample.mounted)) {
    command.mounted = std::move(*parts);
  } else {
    command.mount_error = parts.error().message;
  }
  return command;
}

std::string AboutWhat(const CommandView& command) {
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

/// Obeying it lets less fire: it takes precedence over commands sent at the same time,
/// and is obeyed also when its client has gone.
bool Stops(const CommandView& command) {
  return command.kind == intaglio_COMMAND_PAUSE ||
         command.kind == intaglio_COMMAND_CANCEL;
}

bool Before(const CommandView& a, const CommandView& b) {
  if (Stops(a) != Stops(b)) return Stops(a);
  return std::tie(a.sender, a.number) < std::tie(b.sender, b.number);
}

}  // namespace

CommandInbox::CommandInbox(bus::Bus& bus, JobStore& store)
    : store_(store),
      commands_(bus, bus::kJobCommand),
      answers_(bus, bus::kJobCommandAnswer) {}

void CommandInbox::Take(const Decide& decide, Nanoseconds now) {
  std::vector<CommandView> commands;
  commands_.TakeAll(
      [&](const intaglio_JobCommand& sample, const bus::SampleOrigin& origin) {
        if (origin.alive) {
          commands.push_back(ViewOf(sample));
          return;
        }
        // Its client was answered, gave up waiting, or is gone.
        std::erase_if(commands, [&](const CommandView& command) {
          return !Stops(command) && command.sender == View(sample.sender) &&
                 command.number == sample.number;
        });
      });
  std::sort(commands.begin(), commands.end(), Before);
  for (const CommandView& command : commands) {
    Publish(command, AnswerTo(command, decide));
    answered_.push_back({command.sender, command.number, now});
  }
  DisposeOld(now);
}

CommandAnswer CommandInbox::AnswerTo(const CommandView& command, const Decide& decide) {
  if (const auto answer = store_.AnswerTo(command.sender, command.number)) return *answer;
  const CommandAnswer answer = decide(command);
  store_.KeepAnswer(command, answer);
  if (answer.taken()) {
    host::LogInfo("{}: command {} of {} is accepted{}", AboutWhat(command),
                  static_cast<int>(command.kind), command.operator_name,
                  BasisText(command));
  } else {
    host::LogWarning("{}: command {} of {} is refused: {}", AboutWhat(command),
                     static_cast<int>(command.kind), command.operator_name,
                     answer.message);
  }
  return answer;
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
  while (!answered_.empty() && now - answered_.front().at > kAnswerStays) {
    intaglio_JobCommandAnswer sample{};
    sample.sender = Borrow(answered_.front().sender);
    sample.number = answered_.front().number;
    sample.job_uid = sample.message = Borrow(empty);
    (void)answers_.Dispose(sample);
    answered_.pop_front();
  }
}

}  // namespace intaglio::job_service
