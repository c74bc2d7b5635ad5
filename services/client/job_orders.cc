// The part of JobClient that sends commands.

#include <fmt/format.h>

#include "engrave/core/try.h"
#include "services/client/job_client.h"
#include "services/job/mounted/mounted_sample.h"
#include "services/platform/bus/samples.h"

namespace intaglio::client {
namespace {

using bus::Borrow;
using bus::View;

/// A command, or its key alone.
intaglio_JobCommand CommandOf(const std::string& sender, std::uint64_t number,
                              const std::string& job_uid, const std::string& name) {
  intaglio_JobCommand sample{};
  sample.sender = Borrow(sender);
  sample.number = number;
  sample.job_uid = Borrow(job_uid);
  sample.operator_name = Borrow(name);
  static const std::string kEmpty;
  sample.block_id = sample.cell = sample.mounted.glass = Borrow(kEmpty);
  sample.mounted.lens = sample.mounted.piece = sample.before_job_uid = Borrow(kEmpty);
  sample.worker = Borrow(kEmpty);
  return sample;
}

}  // namespace

Result<std::uint64_t> JobClient::Send(const JobView& job, const JobOrder& order) {
  if (!commands_) return Fail(ErrorCode::kRefused, no_commands_);
  const std::string name = OperatorName();
  intaglio_JobCommand sample = CommandOf(sender_, ++last_number_, job.uid, name);
  sample.epoch = job.epoch;
  sample.kind = order.kind;
  sample.disarm_count = job.disarm_count;
  sample.from_point = order.from_point;
  sample.fire_uncertain = order.fire_uncertain;
  sample.speed_percent = order.speed_percent;
  sample.accept_breakage = order.accept_breakage;
  sample.basis = order.basis;
  sample.block_id = Borrow(order.block_id);
  sample.before_job_uid = Borrow(order.before_job_uid);
  INTAGLIO_TRY(commands_->commands.Write(sample));
  return last_number_;
}

void JobClient::Receive(const intaglio_JobCommandAnswer& answer) {
  if (View(answer.sender) != sender_ || replies_.contains(answer.number)) return;
  replies_[answer.number] = {answer.code, std::string(View(answer.message))};
  Withdraw(answer.number);
}

void JobClient::Withdraw(std::uint64_t number) {
  (void)commands_->commands.Dispose(CommandOf(sender_, number, {}, {}));
}

std::optional<CommandReply> JobClient::AnswerTo(std::uint64_t number) const {
  const auto found = replies_.find(number);
  if (found == replies_.end()) return std::nullopt;
  return found->second;
}

Status JobClient::AwaitCommand(std::uint64_t number, const std::string& what,
                               std::chrono::milliseconds timeout) {
  const Result<bool> answer =
      AwaitAnswer([&] { return AnswerTo(number).has_value(); }, timeout);
  if (!answer || !*answer) {
    Withdraw(number);
    if (!answer) return tl::unexpected(answer.error());
    return Fail(ErrorCode::kTimedOut,
                fmt::format("the job service did not answer the command for {} within "
                            "{:.0f} s: check that it runs (intaglio list) and what it "
                            "shows (intaglio status)",
                            what, std::chrono::duration<double>(timeout).count()));
  }
  const CommandReply reply = *AnswerTo(number);
  if (reply.taken()) return {};
  return Fail(ErrorCode::kRefused,
              fmt::format("refused, {}: {}", NameOf(reply.code), reply.message),
              NameOf(reply.code));
}

Status JobClient::Command(const JobView& job, const JobOrder& order,
                          std::chrono::milliseconds timeout) {
  const auto number = INTAGLIO_TRY(Send(job, order));
  return AwaitCommand(number, fmt::format("job {}", job.number), timeout);
}

Status JobClient::Mount(const std::string& cell, const MountedParts& parts,
                        intaglio_ArmBasis basis, std::chrono::milliseconds timeout) {
  if (!commands_) return Fail(ErrorCode::kRefused, no_commands_);
  const std::string name = OperatorName();
  intaglio_JobCommand sample = CommandOf(sender_, ++last_number_, {}, name);
  sample.kind = intaglio_COMMAND_MOUNT;
  sample.basis = basis;
  sample.cell = Borrow(cell);
  sample.mounted = SampleOf(parts);
  INTAGLIO_TRY(commands_->commands.Write(sample));
  return AwaitCommand(last_number_, cell, timeout);
}

Status JobClient::Admit(const std::string& worker, std::chrono::milliseconds timeout) {
  if (!commands_) return Fail(ErrorCode::kRefused, no_commands_);
  const std::string name = OperatorName();
  intaglio_JobCommand sample = CommandOf(sender_, ++last_number_, {}, name);
  sample.kind = intaglio_COMMAND_ADMIT;
  sample.worker = Borrow(worker);
  INTAGLIO_TRY(commands_->commands.Write(sample));
  return AwaitCommand(last_number_, worker, timeout);
}

}  // namespace intaglio::client
