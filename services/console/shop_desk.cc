#include "services/console/shop_desk.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "services/client/refusal_code.h"
#include "services/client/shop/job_record.h"
#include "services/client/shop/queue_time.h"
#include "services/client/shop/shop_status.h"

namespace intaglio::console {
namespace {

using namespace std::chrono_literals;

constexpr auto kTurn = 20ms;
constexpr auto kAwaitingTurn = 2ms;
constexpr auto kStopAnswerTime = 1s;
// A page shows what is made now; the history has the rest.
constexpr std::size_t kEndedJobsShown = 20;

constexpr char kPressTheButton[] = "press the machine's own button";

/// As a job service names it.
std::string EndedCode() { return client::NameOf(intaglio_ANSWER_ENDED_JOB); }

std::string EndedSentence(const client::JobView& job) {
  return fmt::format("job {} is already {}", job.number, client::NameOf(job.state));
}

}  // namespace

ShopDesk::ShopDesk(bus::Bus& bus)
    : bus_(bus),
      watcher_(bus),
      reports_(bus, ""),
      source_(bus, "intaglio-console", client::kEveryMachine) {}

StopAnswer ShopDesk::Press(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  StopAnswer answer;
  const auto number = source_.Press(reason.empty() ? "pressed in the console" : reason);
  if (number) {
    pressed_ = static_cast<std::uint32_t>(*number);
    pressed_at_ = Clock::now();
    answer.set_sent(true);
    answer.set_number(pressed_);
  } else {
    answer.set_message(
        fmt::format("not sent: {}: {}", number.error().message, kPressTheButton));
  }
  return answer;
}

void ShopDesk::Order(std::function<void(ShopDesk&)> order) {
  const std::lock_guard lock(mutex_);
  orders_.push_back(std::move(order));
}

void ShopDesk::Turn(bool in_haste) {
  watcher_.Poll(IsAwaited() || has_had_orders_ || in_haste ? kAwaitingTurn : kTurn);
  std::vector<std::function<void(ShopDesk&)>> orders;
  {
    const std::lock_guard lock(mutex_);
    orders.swap(orders_);
  }
  has_had_orders_ = !orders.empty();
  for (const auto& order : orders) order(*this);
  AnswerCommands();
  AnswerStops();
  AnswerResets();
}

std::vector<std::string> ShopDesk::TakeEvents() {
  for (const auto& [uid, job] : client().jobs()) {
    const auto [seen, is_new] = ended_.try_emplace(uid, !knows_jobs_ && job.ended());
    if (seen->second) continue;
    if (!job.ended()) {
      if (is_new && job.state == intaglio_JOB_QUEUED) events_.Submitted(job);
      events_.Show(job);
    } else if (client::IsSettled(job)) {
      events_.Ended(job, client::EndOf(client(), job));
      metrics_.CountPiece(job.cell, job.verdict);
      seen->second = true;
    }
  }
  knows_jobs_ = knows_jobs_ || client().KnowsAllJobs();
  std::erase_if(ended_,
                [this](const auto& job) { return !client().jobs().contains(job.first); });
  std::vector<std::string> lines;
  std::istringstream written(lines_.str());
  for (std::string line; std::getline(written, line);) lines.push_back(line);
  lines_.str("");
  return lines;
}

ShopStatus ShopDesk::Status() const {
  return client::StatusOf(watcher_.Take(), std::chrono::system_clock::now());
}

ConsoleState ShopDesk::State() {
  ConsoleState state;
  const client::ShopSnapshot shop = watcher_.Take();
  *state.mutable_shop() = client::StatusOf(shop, std::chrono::system_clock::now());
  metrics_.Follow(state.shop(), Clock::now());
  for (QueueTime& queue :
       client::QueueTimesOf(shop.jobs, std::chrono::system_clock::now()))
    *state.add_queues() = std::move(queue);
  std::size_t ended = 0;
  for (auto job = shop.jobs.rbegin(); job != shop.jobs.rend(); ++job) {
    if (job->ended() && ++ended > kEndedJobsShown) continue;
    *state.add_jobs() = client::JobRecordOf(*job);
  }
  for (const auto& [name, cell] : shop.cells) {
    if (!cell.has_motion) continue;
    StagePosition& stage = *state.add_stages();
    stage.set_cell(name);
    stage.set_x_mm(cell.x_mm);
    stage.set_y_mm(cell.y_mm);
    stage.set_z_mm(cell.z_mm);
    stage.set_at_rest(cell.at_rest);
  }
  if (auto stop = Confirmations(); stop.sent()) {
    if (stop.confirmed()) shown_confirmed_ = stop.number();
    *state.mutable_stop() = std::move(stop);
  }
  return state;
}

std::pair<int, HoldAnswer> ShopDesk::Hold(const std::string& job_name,
                                          const std::string& block) {
  HoldAnswer answer;
  const auto refuse = [&](int status, std::string code, std::string message) {
    answer.set_code(std::move(code));
    answer.set_message(std::move(message));
    return std::pair(status, answer);
  };
  const auto job = client().Find(job_name);
  if (!job) return refuse(404, client::RefusalCode(job.error()), job.error().message);
  const client::ShopSnapshot shop = watcher_.Take();
  const JobRecord record = client::JobRecordOf(*job);
  answer.set_job(job->number);
  answer.set_name(job->name);
  answer.set_cell(job->cell);
  answer.set_block(BlockIn(shop, job->cell));
  *answer.mutable_warnings() = record.warnings();
  if (job->ended()) return refuse(409, EndedCode(), EndedSentence(*job));
  if (const Obstacle obstacle = ObstacleOf(shop, job->cell); !obstacle.code.empty())
    return refuse(409, obstacle.code, obstacle.message);
  if (block != answer.block()) {
    return refuse(409, "other_block",
                  fmt::format("\"{}\" is mounted in {}, and not \"{}\": read it again, "
                              "then press and hold",
                              answer.block(), job->cell, block));
  }
  using Seconds = std::chrono::duration<double>;
  answer.set_token(holds_.Begin(*job, ReportIn(shop, job->cell), Clock::now()));
  answer.set_held(true);
  answer.set_hold_s(Seconds(ArmHolds::kHoldTime).count());
  answer.set_end_s(Seconds(ArmHolds::kHoldTime + ArmHolds::kEndTime).count());
  return {200, answer};
}

std::optional<client::JobView> ShopDesk::OpenJobNamed(const std::string& name,
                                                      const Answer& answer) {
  CommandAnswer refused;
  const auto job = client().Find(name);
  if (job && !job->ended()) return *job;
  refused.set_message(job ? EndedSentence(*job) : job.error().message);
  refused.set_code(job ? EndedCode() : client::RefusalCode(job.error()));
  if (job) refused.set_job(job->number);
  answer(job ? 409 : 404, refused);
  return std::nullopt;
}

void ShopDesk::Command(const std::string& job_name, const client::JobOrder& order,
                       Answer answer) {
  if (const auto job = OpenJobNamed(job_name, answer))
    Send(*job, order, std::move(answer));
}

void ShopDesk::Fire(const std::string& job_name, const std::string& token,
                    client::JobOrder order, Answer answer) {
  const auto job = OpenJobNamed(job_name, answer);
  if (!job) return;
  const client::ShopSnapshot shop = watcher_.Take();
  const auto held =
      holds_.End(token, job->uid, ReportIn(shop, job->cell), ArmHolds::Clock::now());
  const Obstacle obstacle =
      held ? ObstacleOf(shop, job->cell) : Obstacle{"not_held", held.error().message};
  if (!obstacle.code.empty()) {
    CommandAnswer refused;
    refused.set_job(job->number);
    refused.set_code(obstacle.code);
    refused.set_message(obstacle.message);
    return answer(409, refused);
  }
  order.basis = intaglio_ARM_BY_PERSON;
  Send(*held, order, std::move(answer));
}

void ShopDesk::Send(const client::JobView& job, const client::JobOrder& order,
                    Answer answer) {
  CommandAnswer pending;
  pending.set_job(job.number);
  const auto number = client().Send(job, order);
  if (!number) {
    pending.set_code(client::RefusalCode(number.error()));
    pending.set_message(number.error().message);
    return answer(503, pending);
  }
  commands_.push_back({*number, pending, Clock::now() + client::JobClient::kAnswerTime,
                       std::move(answer)});
}

void ShopDesk::AnswerCommands() {
  const auto now = Clock::now();
  std::erase_if(commands_, [&](PendingCommand& command) {
    if (const auto reply = client().AnswerTo(command.number)) {
      command.answer.set_taken(reply->taken());
      command.answer.set_code(client::NameOf(reply->code));
      command.answer.set_message(reply->message);
      command.reply(reply->taken() ? 200 : 409, command.answer);
      return true;
    }
    if (now < command.end) return false;
    client().Withdraw(command.number);
    command.answer.set_code(ErrorCodeName(ErrorCode::kTimedOut));
    command.answer.set_message(
        "the job service did not answer; the command is withdrawn: check that it runs");
    command.reply(504, command.answer);
    return true;
  });
}

void ShopDesk::Reset(const std::string& cell, const std::set<std::string>& presses,
                     const std::string& person, Answer answer) {
  CommandAnswer refused;
  const auto refuse = [&](int status, ErrorCode code, std::string message) {
    refused.set_code(ErrorCodeName(code));
    refused.set_message(std::move(message));
    answer(status, refused);
  };
  const auto& machines = reports_.Poll();
  const auto machine = machines.find(cell);
  if (machine == machines.end())
    return refuse(404, ErrorCode::kNotFound, fmt::format("no machine {} is there", cell));
  client::HeldPresses seen;
  std::ranges::copy_if(machine->second.held, std::back_inserter(seen),
                       [&](const client::HeldPress& press) {
                         return presses.contains(client::TextOf(press));
                       });
  const bool is_latched = machine->second.laser_line_up &&
                          !machine->second.own_stop_released && presses.empty();
  if (seen.empty() && !is_latched) {
    return refuse(409, ErrorCode::kRefused,
                  fmt::format("{} holds none of these presses any more: read again what "
                              "it holds",
                              cell));
  }
  auto reset = std::make_unique<client::StopReset>(bus_, "intaglio-console", cell, seen,
                                                   "reset in the console by " + person);
  if (const auto sent = reset->Turn(machine->second, Clock::now()); !sent)
    return refuse(503, sent.error().code, sent.error().message);
  resets_.push_back({cell, std::move(reset),
                     Clock::now() + client::JobClient::kAnswerTime, std::move(answer)});
}

void ShopDesk::AnswerResets() {
  if (resets_.empty()) return;
  const auto& machines = reports_.Poll();
  std::erase_if(resets_, [&](const PendingReset& pending) {
    const auto machine = machines.find(pending.cell);
    if (machine != machines.end())
      (void)pending.reset->Turn(machine->second, Clock::now());
    const bool is_done = pending.reset->is_over();
    if (!is_done && Clock::now() < pending.end) return false;
    CommandAnswer answer;
    answer.set_taken(is_done);
    answer.set_message(is_done ? client::WhyStillHeld(pending.cell, machine->second)
                               : pending.cell +
                                     " has not confirmed the reset: check that "
                                     "its services run");
    if (!is_done) answer.set_code(ErrorCodeName(ErrorCode::kTimedOut));
    pending.reply(is_done ? 200 : 504, answer);
    return true;
  });
}

void ShopDesk::AwaitConfirmation(std::uint32_t number,
                                 std::function<void(const StopAnswer&)> answer) {
  if (number > 0) stops_.push_back({Clock::now() + kStopAnswerTime, std::move(answer)});
}

void ShopDesk::AnswerStops() {
  if (stops_.empty()) return;
  const StopAnswer answer = Confirmations();
  const auto now = Clock::now();
  std::erase_if(stops_, [&](const PendingStop& stop) {
    if (!answer.confirmed() && now < stop.end) return false;
    stop.reply(answer);
    return true;
  });
}

bool ShopDesk::IsStopAwaited() {
  const std::lock_guard lock(mutex_);
  return pressed_ != shown_confirmed_ && Clock::now() - pressed_at_ < kStopAnswerTime;
}

bool ShopDesk::IsConfirmedAnew() {
  return IsStopAwaited() && Confirmations().confirmed();
}

StopAnswer ShopDesk::Confirmations() {
  StopAnswer answer;
  {
    const std::lock_guard lock(mutex_);
    answer.set_number(pressed_);
    answer.set_sent(pressed_ > 0);
  }
  const client::ShopSnapshot shop = watcher_.Take();
  std::string missing;
  for (const auto& [cell, stops] : reports_.Poll()) {
    StopConfirmation& machine = *answer.add_machines();
    machine.set_cell(cell);
    machine.set_confirmed(client::Names(stops.held, source_.name(), answer.number()));
    machine.set_laser_line_up(stops.laser_line_up);
    machine.set_shutters_closed(stops.laser_line_up && stops.shutters_closed);
    const auto motion = shop.cells.find(cell);
    machine.set_at_rest(motion != shop.cells.end() && motion->second.has_motion &&
                        motion->second.at_rest);
    if (!machine.confirmed()) missing += (missing.empty() ? "" : ", ") + cell;
  }
  answer.set_confirmed(answer.sent() && missing.empty() && answer.machines_size() > 0);
  if (answer.machines_size() == 0)
    answer.set_message(fmt::format("no machine found: {}", kPressTheButton));
  else if (answer.sent() && !missing.empty())
    answer.set_message(
        fmt::format("{}: not confirmed yet: {}", missing, kPressTheButton));
  return answer;
}

}  // namespace intaglio::console
