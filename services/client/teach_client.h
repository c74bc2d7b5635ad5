#pragma once

// A client that moves a machine by hand and teaches it. The motion bridge executes and
// answers (services/cell/manual); an order that moves is held by repeating it:
// when this process ends, or stops polling, the stage is at rest within 200 ms and the
// time of braking.

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "idl/teach.h"
#include "services/platform/bus/bus.h"

namespace intaglio::client {

/// The machine as its bridge and its synchronizer publish it.
struct MachineView {
  std::string cell;
  std::uint64_t number = 0;  ///< of the ManualState; 0: none came
  std::string held_by, refusal, profile;
  bool homed = true;
  std::array<std::string, 3> axes;
  std::array<bool, 3> rotary = {false, false, false};
  Vec3 position = Vec3::Zero(), limit_min = Vec3::Zero(), limit_max = Vec3::Zero();
  std::uint32_t taught_number = 0;
  std::string answered_sender;
  std::uint64_t answered_number = 0;
  intaglio_ManualAnswer answer = intaglio_MANUAL_DONE;
  std::string message;
  /// It was refused because the bridge had no report of permission, key or door: it may
  /// be given again.
  bool reports_missing = false;
  bool interlocks_known = false;
  bool key_on = false, door_closed = false, door_locked = false, stop_released = false,
       lamp_on = false, lamp_warm = false;
  bool lamp_by_hand = false;          ///< held by a person
  std::uint8_t shutters_by_hand = 0;  ///< mask, likewise
  std::uint8_t shutters_open = 0;
};

/// Fills in what the state of a motion bridge has.
void TakeState(const intaglio_ManualState& sample, MachineView& view);

struct TeachOrder {
  intaglio_ManualCommandKind kind = intaglio_MANUAL_NONE;
  Vec3 place = Vec3::Zero(), place_max = Vec3::Zero();
  double speed_mm_s = 0;
  std::uint32_t channel = 1;
  std::string lens = {};
  std::uint8_t sets = 7;
  bool forget = false;
  /// Corners of an outline, by the first two axes, mm; as many of each.
  std::vector<double> outline_x_mm = {}, outline_y_mm = {};
};

/// An order as it is sent, each time that it is repeated.
struct SentOrder {
  std::string cell;
  std::string sender;        ///< of one person at one program; no other has it
  std::uint64_t number = 0;  ///< of the order (bus/manual_orders.h)
  std::uint64_t seen = 0;    ///< `number` of the MachineView that the person saw last
  std::string operator_name;
  TeachOrder order = {};
};

/// The sample borrows the texts and corners of `sent`.
intaglio_ManualCommand SampleOf(const SentOrder& sent);

class TeachClient {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kRepeatTime{40};

  /// `cell`: the machine, or empty: the only one that is found. kNotFound; kInvalidValue
  /// names those that there are.
  static Result<std::string> FindMachine(bus::Bus& bus, const std::string& cell);

  /// Throws bus::NotAllowedError when its identity may not command.
  TeachClient(bus::Bus& bus, std::string cell);
  ~TeachClient();

  /// Takes what has come, repeats what is held.
  void Poll();
  const MachineView& view() const { return view_; }
  /// The bridge answers, and takes orders from now on. kTimedOut.
  Status Connect(std::chrono::milliseconds timeout = std::chrono::seconds(5));

  /// From now on, until LetGo or another order; the order's number.
  std::uint64_t Hold(const TeachOrder& order);
  void LetGo();
  /// Once the order was answered, by its number.
  bool IsAnswered(std::uint64_t number) const;
  /// It is executed, by the newest state.
  bool IsHeld(std::uint64_t number) const;

  /// Holds the order until it is answered for good. The bridge's sentence, or kRefused
  /// with it; kCancelled when `cancelled` held; kTimedOut when neither an answer has come
  /// for `timeout` nor the machine has moved, whose travel in rad says nothing of its
  /// time.
  Result<std::string> Execute(const TeachOrder& order, std::chrono::milliseconds timeout,
                              const std::function<bool()>& cancelled = {});

 private:
  void Send(bool at_once);

  std::string sender_, operator_name_;
  bus::Reader<intaglio_ManualState> states_;
  bus::Reader<intaglio_Interlock> interlocks_;
  bus::Writer<intaglio_ManualCommand> commands_;
  MachineView view_;
  TeachOrder held_;
  std::uint64_t number_ = 0;
  Clock::time_point next_send_;
};

}  // namespace intaglio::client
