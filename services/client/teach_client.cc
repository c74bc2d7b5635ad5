#include "services/client/teach_client.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <random>
#include <set>
#include <sstream>
#include <thread>

#include "services/client/job_client.h"
#include "services/client/listed_services.h"
#include "services/platform/bus/manual_orders.h"
#include "services/platform/bus/samples.h"

namespace intaglio::client {
namespace {

using bus::Borrow;
using bus::View;
using namespace std::chrono_literals;

constexpr std::chrono::hours kLongestMove{1};
constexpr auto kPollTime = 5ms;

std::string NewSender() {
  std::random_device random;
  return fmt::format("{}-{}-{:08x}", OperatorName(), getpid(), random());
}

Vec3 VectorOf(const double (&values)[3]) { return {values[0], values[1], values[2]}; }

void Put(const Vec3& from, double (&to)[3]) {
  for (int i = 0; i < 3; ++i) to[i] = from[i];
}

}  // namespace

void TakeState(const intaglio_ManualState& sample, MachineView& view) {
  view.number = sample.number;
  view.held_by = View(sample.held_by);
  view.refusal = View(sample.refusal);
  view.profile = View(sample.profile);
  view.homed = sample.homed;
  std::istringstream names{std::string(View(sample.axes))};
  for (std::size_t i = 0; i < 3; ++i) {
    names >> view.axes[i];
    view.rotary[i] = (sample.rotary >> i & 1) != 0;
  }
  view.position = VectorOf(sample.position);
  view.limit_min = VectorOf(sample.limit_min);
  view.limit_max = VectorOf(sample.limit_max);
  view.taught_number = sample.taught_number;
  view.lamp_by_hand = sample.lamp_by_hand;
  view.shutters_by_hand = sample.shutters_by_hand;
  view.answered_sender = View(sample.answered_sender);
  view.answered_number = sample.answered_number;
  view.answer = sample.answer;
  view.message = View(sample.message);
  view.reports_missing = sample.reports_missing;
}

intaglio_ManualCommand SampleOf(const SentOrder& sent) {
  intaglio_ManualCommand sample{};
  sample.cell = Borrow(sent.cell);
  sample.sender = Borrow(sent.sender);
  sample.number = sent.number;
  sample.seen = sent.seen;
  sample.kind = sent.order.kind;
  sample.operator_name = Borrow(sent.operator_name);
  Put(sent.order.place, sample.place);
  Put(sent.order.place_max, sample.place_max);
  sample.speed_mm_s = sent.order.speed_mm_s;
  sample.channel = sent.order.channel;
  sample.lens = Borrow(sent.order.lens);
  sample.sets = sent.order.sets;
  sample.forget = sent.order.forget;
  Borrow(sample.outline_x_mm, sent.order.outline_x_mm);
  Borrow(sample.outline_y_mm, sent.order.outline_y_mm);
  return sample;
}

Result<std::string> TeachClient::FindMachine(bus::Bus& bus, const std::string& cell) {
  if (!cell.empty()) return cell;
  bus::Reader<intaglio_ManualState> states(bus, bus::kManualState);
  ListedServices listed(bus);
  std::set<std::string> cells;
  // Without a list a machine may be on its way until the time is up. A mill or a cutter
  // has no motion bridge, and is moved by hand as well.
  for (const auto end = Clock::now() + bus.discovery_time() + 600ms;
       Clock::now() < end && !listed.AreAllIn(cells, kMachineRoles);) {
    states.Take([&](const intaglio_ManualState& state) {
      cells.insert(std::string(View(state.cell)));
    });
    listed.Poll();
    std::this_thread::sleep_for(kPollTime);
  }
  if (cells.size() == 1) return *cells.begin();
  if (cells.empty()) {
    return Fail(ErrorCode::kNotFound,
                "no machine found: check that its motion bridge or marker runs (intaglio "
                "up), and --domain, --interface, --tag and --security");
  }
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("several machines found ({}): name one with --cell",
                          fmt::join(cells, ", ")));
}

TeachClient::TeachClient(bus::Bus& bus, std::string cell)
    : sender_(NewSender()),
      operator_name_(OperatorName()),
      states_(bus, bus::kManualState, cell),
      interlocks_(bus, bus::kInterlock, cell),
      commands_(bus, bus::kManualCommand, cell) {
  view_.cell = std::move(cell);
}

// The bridge would notice the silence, too.
TeachClient::~TeachClient() { LetGo(); }

void TeachClient::Poll() {
  states_.Take([this](const intaglio_ManualState& sample) { TakeState(sample, view_); });
  interlocks_.TakeAll(
      [this](const intaglio_Interlock& sample, const bus::SampleOrigin& origin) {
        view_.interlocks_known = origin.alive && sample.laser_link_up;
        if (!origin.alive) return;
        view_.key_on = sample.key_on;
        view_.door_closed = sample.door_closed;
        view_.door_locked = sample.door_locked;
        view_.stop_released = sample.emergency_stop_released;
        view_.lamp_on = sample.lamp_on;
        view_.lamp_warm = sample.lamp_warm;
        view_.shutters_open = sample.shutters_open;
      });
  Send(false);
}

void TeachClient::Send(bool at_once) {
  if (!at_once && Clock::now() < next_send_) return;
  next_send_ = Clock::now() + kRepeatTime;
  (void)commands_.Write(
      SampleOf({view_.cell, sender_, number_, view_.number, operator_name_, held_}));
}

// States come every 20 ms once the bridge has a command; two in a row show that.
Status TeachClient::Connect(std::chrono::milliseconds timeout) {
  std::uint64_t first = 0;
  for (const auto end = Clock::now() + timeout; Clock::now() < end;) {
    Poll();
    if (first == 0) first = view_.number;
    if (commands_.matched_count() > 0 && first != 0 && view_.number > first + 2)
      return {};
    std::this_thread::sleep_for(kPollTime);
  }
  return Fail(
      ErrorCode::kTimedOut,
      fmt::format("the motion bridge of {} does not answer: check that it runs "
                  "(intaglio up), and --domain, --interface, --tag and --security",
                  view_.cell));
}

std::uint64_t TeachClient::Hold(const TeachOrder& order) {
  held_ = order;
  number_ = bus::NumberOfOrder(number_, view_.number);
  Send(true);
  return number_;
}

void TeachClient::LetGo() {
  if (held_.kind == intaglio_MANUAL_NONE) return;
  held_ = {};
  Send(true);
}

bool TeachClient::IsAnswered(std::uint64_t number) const {
  return view_.answered_sender == sender_ && view_.answered_number == number &&
         view_.answer != intaglio_MANUAL_ACCEPTED;
}

bool TeachClient::IsHeld(std::uint64_t number) const {
  return view_.held_by == sender_ && view_.answered_sender == sender_ &&
         view_.answered_number == number && view_.answer == intaglio_MANUAL_ACCEPTED;
}

Result<std::string> TeachClient::Execute(const TeachOrder& order,
                                         std::chrono::milliseconds timeout,
                                         const std::function<bool()>& cancelled) {
  const std::uint64_t number = Hold(order);
  const auto last_end = Clock::now() + kLongestMove;
  auto end = Clock::now() + timeout;
  Vec3 place = view_.position;
  while (!IsAnswered(number)) {
    const bool is_cancelled = cancelled && cancelled();
    if (is_cancelled || Clock::now() > end) {
      LetGo();
      if (is_cancelled) return Fail(ErrorCode::kCancelled, "let go");
      return Fail(ErrorCode::kTimedOut,
                  fmt::format("{} has not answered within {} s: check its motion bridge",
                              view_.cell, timeout.count() / 1000));
    }
    std::this_thread::sleep_for(kPollTime);
    Poll();
    if (view_.position == place) continue;
    place = view_.position;
    end = std::max(end, std::min(Clock::now() + timeout, last_end));
  }
  held_ = {};
  Send(true);
  if (view_.answer == intaglio_MANUAL_DONE) return view_.message;
  return Fail(ErrorCode::kRefused, view_.message);
}

}  // namespace intaglio::client
