#include "services/job_service/records/job_arm.h"

#include <fmt/format.h>

#include <algorithm>

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;

constexpr Nanoseconds kFirstWait = 300ms;
constexpr Nanoseconds kMaxWait = 3s;

std::string IdOf(const CommandView& command) {
  return fmt::format("{}/{}", command.sender, command.number);
}

}  // namespace

bool SpendsTheGrant(intaglio_PauseReason reason) {
  return reason != intaglio_PAUSE_NONE && reason != intaglio_PAUSE_NOT_ARMED;
}

KeptArm JobArm::ToKeep() const {
  KeptArm kept = kept_;
  kept.armed = kept_.armed && !absence_.absent();
  return kept;
}

bool JobArm::IsRepeated(const CommandView& command) const {
  return IdOf(command) == kept_.last_command_id;
}

void JobArm::Note(const CommandView& command) {
  kept_.last_command_id = IdOf(command);
  if (command.kind == intaglio_COMMAND_SPEED || command.kind == intaglio_COMMAND_MOVE)
    return;
  ++kept_.last_command;
  kept_.fire_uncertain = false;
}

void JobArm::Arm(const CommandView& command, Nanoseconds now) {
  kept_.operator_name = command.operator_name;
  if (command.accept_breakage) {
    kept_.breakage_accepted_by =
        command.operator_name.empty() ? "operator" : command.operator_name;
  }
  kept_.first_point = std::max(kept_.first_point, command.from_point);
  kept_.fire_uncertain =
      command.fire_uncertain && command.kind == intaglio_COMMAND_RESUME;
  if (command.basis == intaglio_ARM_BY_LOADER) kept_.block_id = command.block_id;
  kept_.armed = true;
  renewal_count_ = 0;
  absence_.Restart(now);
  armed_at_ = std::max(now, withdrawn_at_ + kHold);
}

void JobArm::Disarm(const std::string& reason, Nanoseconds now) {
  ++kept_.disarm_count;
  kept_.disarm_reason = reason;
  if (!kept_.armed) return;
  kept_.armed = false;
  withdrawn_at_ = now;
}

void JobArm::Renew(std::uint64_t done_count, std::uint64_t renewal, Nanoseconds now) {
  if (kept_.asks_before_resume) return;
  if (done_count != done_at_renewal_) renewal_count_ = 0;
  done_at_renewal_ = done_count;
  if (renewal_count_ >= kMaxRenewals) return;
  armed_at_ = now + std::min(kMaxWait, kFirstWait * (1 << std::min(renewal_count_, 8u)));
  ++renewal_count_;
  kept_.armed = true;
  renewal_ = renewal;
}

}  // namespace intaglio::job_service
