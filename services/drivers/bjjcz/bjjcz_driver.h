#pragma once

// Marks by a BJJCZ board (LMC, of EzCad 2; USB or TCP):
// services/drivers/interface/mark_driver.h, protocol "bjjcz" of mark_line.
// docs/machines/bjjcz.md has wiring and settings.
//
//   marks --MarkLists--> lists --LmcLine--> board
//                                 |            |
//                                 v            v
//        kBegun: before its first list    BUSY is gone behind its last: kDone
//
// By hand a guide laser draws an outline (mark_hand.h): between runs, with the gate off.
//
// One mark is in hand at a time, and one list is in the board: it is given when BUSY of
// the one before has gone, and executed when the permission outlasts it.
//
// What this family does not keep by itself of the guarantees of mark_driver.h:
//  - K2: the board has no watchdog, and plays what it has to the end. So that is one list
//    of at most kMaxListSeconds, which is executed only if it ends within 250 ms of the
//    newest permission: a dead host, a late one and a lost line leave no more. A board
//    whose clock or speeds differ from what the profile has it takes as much longer;
//    gate_output stays on then. An external gate has to end the beam for key, door and
//    stop button.
//  - K4, Stop: the gate is closed, then the list stopped (0x1F, and an empty list, since
//    some boards act on the next one alone).
//  - K6: it remembers no mark. What this object has seen is answered, else kUncertain:
//    one mark at most. Whether the board's count of marks could tell more is not known.
//  - K7: key, door and stop button are one chain at an input that the host reads every 5
//    ms; openings that are shorter, or without a host, are not seen.
//  - K12: a host that dies and a line that is lost leave the guide laser of an outline
//  on,
//    at rest behind one list, until the line is back.
//  - K9: it gives no number of its power-up, and a cable that was pulled looks like a
//    power cycle: each session is another power_up.

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "proto/machine.pb.h"
#include "services/drivers/bjjcz/board_list.h"
#include "services/drivers/bjjcz/lmc_line.h"
#include "services/drivers/bjjcz/mark_hand.h"
#include "services/drivers/bjjcz/mark_lists.h"
#include "services/drivers/interface/mark_driver.h"
#include "services/drivers/interface/seen_marks.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

class BjjczDriver final : public MarkDriver {
 public:
  static constexpr std::size_t kMaxQueuedMarks = 64;
  static constexpr std::chrono::milliseconds kLease{250};

  /// `broken`: what is wrong with the profile; then nothing is sent. Empty: nothing is.
  BjjczDriver(const MachineSpec& machine, std::vector<LmcCommand> set_up,
              std::string broken, link::StreamOpener open, link::SteadyClock clock);

  HandMotion* hand() override { return &guide_; }
  void Poll() override;
  int fd() const override { return line_.fd(); }
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
  enum class Hand { kNone, kAnnounced, kMaking };
  void Receive(const LmcAnswer& answer);
  void TakeInputs(std::uint16_t inputs);
  void TakeLost();
  void Feed();
  void FeedGuide();
  void TakeNextMark();
  void SendList();
  void ExecuteList();
  void CheckList();
  void FeedOutputs();
  void EndMark(MarkFate fate);
  void EndRun();
  /// Events of what was appended, and nothing more of it.
  void DropAll();
  void BeginStop(std::string fault);
  bool is_permitted_for(double seconds) const;
  std::uint16_t WantedOutputs() const;
  bool gate_is_open() const;
  void AddEvent(std::uint32_t mark, MarkFate fate);
  void Report();

  BjjczBoard board_;
  std::string broken_;
  link::SteadyClock clock_;
  LmcLine line_;
  MarkLists lists_;
  MarkDeviceState state_;
  BjjczMarkHand guide_;
  SeenMarks seen_;
  std::vector<MarkEvent> events_;

  std::optional<std::uint32_t> run_;
  bool finishes_ = false, stopping_ = false;
  std::deque<NumberedMark> queue_;
  std::optional<NumberedMark> hand_;
  Hand stage_ = Hand::kNone;
  bool begun_ = false;  ///< a list of the mark in hand may have been executed
  std::optional<PlayedList> playing_;  ///< in the board, or on its way to it
  std::optional<std::chrono::nanoseconds> permit_at_;
  // Of the newest session.
  bool has_inputs_ = false, closed_ = false, busy_ = false;
  std::optional<std::uint16_t> asked_outputs_, outputs_;
};

std::unique_ptr<MarkDriver> MakeBjjczDriver(const MachineSpec& machine,
                                            link::StreamOpener open,
                                            link::SteadyClock clock);

}  // namespace intaglio::drivers
