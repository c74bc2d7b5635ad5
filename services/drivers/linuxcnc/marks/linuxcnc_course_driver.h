#pragma once

// Marks by LinuxCNC's HAL with deploy/linuxcnc/start --beam: a laser that follows
// contours, each planned by the planner of courses (contour_plan.h), so that corners are
// passed as fast as the tolerance of the profile allows. Protocol "linuxcnc-course" of
// mark_line; the device is the folder of deploy/linuxcnc/start. A spindle is refused.
//
//   marks --PlanContour, a thread beside--> MarkRows --rows, one a servo period--> HAL
//                                              |                                    |
//                                              v                                    v
//                              kBegun: before its first row       report of its last:
//                              kDone
//
// One mark is in hand at a time. Rows are sent at most kLead_s ahead of the newest one
// that HAL has reported; between two marks none is sent, and the axes rest at the last
// one. Each lit row is gated: HAL ends the beam in a period in which the axes are farther
// from their row than x-, y- or z-near.difference, and then the run ends.
//
// What HAL keeps of the guarantees of mark_driver.h, and what the host does:
//  - K2: each permission is an edge that HAL counts 250 ms from (beam.hal); the watchdog
//    of the host has 200 ms. The host stops the run, and withdraws a permission, at once.
//  - K4: Stop raises the numbers of arm and motion: rows that wait in HAL's stream switch
//    no beam and move nothing, and the axes brake within the limits of the HAL file.
//  - K6: it remembers no mark. What this object has seen is answered, else kUncertain.
//    A mark of which no lit row was played with the beam on ends as kNotBegun.
//  - K9: HAL counts openings of key, door and stop button; drives that fell out, a place
//    that was lost, a watchdog that tripped, and rows that came too late or without the
//    beam are counted here. Each session is another power_up: nobody has watched what was
//    before. Latches are reset at the first session of an object; else by Reset alone.
//  - K10: axes-homed of the axes' file. The file homes them, not the driver.
//  - K11: a beam does not rest in the work: Hold is refused.
//
// Frame: of the piece, whose origin is at block_origin_mm of the axes; z of the axes
// rests.

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proto/machine.pb.h"
#include "services/drivers/interface/mark_driver.h"
#include "services/drivers/interface/seen_marks.h"
#include "services/drivers/linuxcnc/hal_session.h"
#include "services/drivers/linuxcnc/marks/contour_plan.h"
#include "services/drivers/linuxcnc/marks/mark_rows.h"
#include "services/platform/host/threads/computation.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

class LinuxcncCourseDriver final : public MarkDriver {
 public:
  /// As long as the watchdog of HAL waits: a host that is late by less loses no contour,
  /// and rows of a dead one switch nothing on behind it.
  static constexpr double kLead_s = 0.2;
  static constexpr std::size_t kQueuedMarks = 64;
  /// Contours that are planned ahead of the one in hand.
  static constexpr std::size_t kPlannedMarks = 2;
  static constexpr std::chrono::milliseconds kPermission{250};

  LinuxcncCourseDriver(const MachineSpec& machine, HalOpener open,
                       link::SteadyClock clock);

  void Poll() override;
  int fd() const override { return session_.fd(); }
  const MarkDeviceState& state() const override { return state_; }
  std::vector<MarkEvent> TakeEvents() override;
  Status Permit(bool permitted) override;
  Status Begin(std::uint32_t run, std::span<const mark::Pen> pens) override;
  std::size_t Room() const override;
  Status Append(const NumberedMark& mark) override;
  Status Finish() override;
  Status Pause() override;
  Status Stop() override;
  Status Reset() override;
  Status RequestPast(std::uint32_t run, std::uint32_t first,
                     std::uint32_t count) override;

 private:
  using Plan = host::Computation<ContourPlan>;
  struct Queued {
    NumberedMark mark;
    std::unique_ptr<Plan> plan;  ///< null: not yet
  };
  /// A row that HAL has not reported yet.
  struct SentRow {
    std::uint64_t number = 0, motion = 0;
    bool lit = false;
    bool last = false;  ///< of its mark
  };
  enum class Hand { kNone, kAnnounced, kSending };

  void BeginSession();
  void SetDown();
  void Receive(const HalSample& sample);
  void TakeRow(const HalSample& sample);
  void TakeRest(const HalSample& sample);
  void TakeHomed(const HalSample& sample);
  void TakeLatches(const HalSample& sample);

  void CheckPermission();
  bool is_permitted() const {
    return permit_at_ && clock_() - *permit_at_ <= kPermission;
  }
  void Feed();
  void StartPlans();
  void TakeFirst();
  void SendRows();
  void EndMark(MarkFate fate);
  void EndRun();
  void DropQueue();
  void BeginStop();
  void EndStop();
  /// A stop of the controller's own.
  void StopItself(std::string why);
  void Fault(std::string why);
  void EndFault();
  void AddEvent(std::uint32_t mark, MarkFate fate);
  void Report();
  double period_s() const { return session_.identity().period_ns * 1e-9; }

  MachineSpec machine_;
  link::SteadyClock clock_;
  HalSession session_;
  Vec2 origin_mm_;
  MarkDeviceState state_;
  std::uint64_t begun_sessions_ = 0;
  std::vector<MarkEvent> events_;
  SeenMarks seen_;

  std::optional<std::uint32_t> run_;
  std::vector<mark::Pen> pens_;
  bool finishes_ = false;
  std::deque<Queued> queue_;
  std::vector<std::unique_ptr<Plan>> abandoned_;  ///< until their threads end
  std::optional<NumberedMark> hand_;
  std::shared_ptr<const ContourPlan> plan_;  ///< of the mark in hand
  Hand stage_ = Hand::kNone;
  bool was_lit_ = false;  ///< the beam was on since the mark in hand was begun

  MarkRows rows_;
  std::deque<SentRow> sent_;
  std::uint64_t next_row_ = 0;
  bool playing_ = false;  ///< the newest row is followed by another one of its mark
  bool rests_ = false;    ///< place_mm_ is where the axes rest
  int still_samples_ = 0;
  Vec3 place_mm_ = Vec3::Zero(), last_actual_mm_ = Vec3::Zero();

  std::optional<std::chrono::nanoseconds> permit_at_;
  bool shutter_ = false;  ///< as it is commanded
  bool stopping_ = false;
  bool ready_ = false;     ///< the session knows where the axes rest, and its latches
  bool recovers_ = false;  ///< a reset of the latches is on its way
  std::uint64_t reset_number_ = 0;
  std::uint32_t own_stops_ = 0, openings_at_ok_ = 0;
  bool was_homed_ = false;
};

std::unique_ptr<MarkDriver> MakeLinuxcncCourseDriver(const MachineSpec& machine,
                                                     link::StreamOpener open,
                                                     link::SteadyClock clock);

}  // namespace intaglio::drivers
