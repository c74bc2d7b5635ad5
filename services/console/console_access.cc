#include "services/console/console_access.h"

#include <fmt/format.h>

namespace intaglio::console {

std::optional<Visitor> ConsoleAccess::VisitorOf(const web::Caller& caller) const {
  if (caller.session == web::kKeySession)
    return Visitor{caller.session, kKeyName, access::UserRole::kOperator};
  const auto session = log_ins_.At(caller.session, Clock::now());
  if (!session) return std::nullopt;
  return Visitor{session->id, session->name, session->role, session->rests};
}

std::optional<Refusal> ConsoleAccess::WhyNot(Right right, const Visitor& visitor) {
  if (right == Right::kOpen || right == Right::kRead) return std::nullopt;
  if (visitor.rests) {
    return Refusal{
        403, "resting",
        fmt::format("{} has done nothing here for 30 minutes, and may look and "
                    "press Stop: log in again to command",
                    visitor.name)};
  }
  if (visitor.role != access::UserRole::kOperator) {
    return Refusal{
        403, "not_operator",
        fmt::format("{} is an observer, who may look and press Stop", visitor.name)};
  }
  if (right == Right::kOperate) return std::nullopt;
  const std::lock_guard lock(mutex_);
  if (in_charge_.empty()) in_charge_ = visitor.name;
  if (in_charge_ == visitor.name) return std::nullopt;
  return Refusal{
      409, "not_in_charge",
      fmt::format("{} is in charge: agree with each other, then take over", in_charge_)};
}

void ConsoleAccess::TakeCharge(const Visitor& visitor) {
  const std::lock_guard lock(mutex_);
  in_charge_ = visitor.name;
}

std::string ConsoleAccess::InCharge() const {
  const std::lock_guard lock(mutex_);
  return in_charge_;
}

ConsoleSession ConsoleAccess::SessionOf(const Visitor& visitor) const {
  ConsoleSession session;
  session.set_name(visitor.name);
  session.set_role(access::NameOf(visitor.role));
  session.set_rests(visitor.rests);
  session.set_in_charge(InCharge());
  return session;
}

std::vector<std::string> ConsoleAccess::TakeEnded(Clock::time_point now) {
  auto ended = log_ins_.TakeEnded(now);
  const std::lock_guard lock(mutex_);
  if (in_charge_ != kKeyName && !log_ins_.IsHere(in_charge_, now)) in_charge_.clear();
  return ended;
}

}  // namespace intaglio::console
