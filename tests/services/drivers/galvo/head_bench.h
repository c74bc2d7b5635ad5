#pragma once

// The driver of a scan head at a virtual head of the same process, with time by hand.

#include <deque>
#include <filesystem>
#include <memory>

#include "engrave/formats/mark_record.h"
#include "proto/machine.pb.h"
#include "services/drivers/galvo/galvo_driver.h"
#include "services/virtual_engraver/head/head_machine.h"

namespace intaglio::drivers {

/// Field of 100 mm, a lag of 0.2 ms, at rest.
MachineSpec HeadProfile();
virtual_engraver::HeadOptions HeadTruthOf(const MachineSpec& machine);

/// A circle of chords' arcs, closed.
mark::Mark CircleMark(const Vec2& centre_mm, double diameter_mm, double web_mm = 0);
mark::Mark LineMark(const Vec2& from_mm, const Vec2& to_mm);

class HeadBench {
 public:
  HeadBench(const MachineSpec& machine, const virtual_engraver::HeadOptions& head);
  ~HeadBench();

  /// A new driver in place of the one before, as when its process was killed.
  void Restart();
  /// At the end of a new line to the head; the caller polls it, and moves the time.
  std::unique_ptr<MarkDriver> NewDriver(const MachineSpec& profile);
  /// Moves the time of the head alone.
  void AdvanceHead(std::chrono::milliseconds time);
  /// Since the head's newest power-up.
  std::uint64_t burnt_ticks() const { return machine_ ? machine_->burnt_ticks() : 0; }
  void SwitchOff();
  /// With another power-up, and a new record of what it burns.
  void SwitchOn();
  /// The line carries nothing from now on.
  void CutLine() { cut_ = true; }
  void JoinLine() { cut_ = false; }

  /// 0.2 ms of both; the host permits every 20 ms while `permits`, and takes events.
  void Step();
  template <typename Done>
  bool Until(Done&& done, double within_s = 5) {
    for (double s = 0; s < within_s; s += 2e-4) {
      if (done()) return true;
      Step();
    }
    return done();
  }
  bool Connect() {
    return Until([&] { return state().link_up; });
  }
  /// A run of these marks, begun, all appended and finished.
  void Run(std::uint32_t run, const mark::MarkSet& set, bool finish = true);

  MarkDriver& driver() { return *driver_; }
  const MarkDeviceState& state() { return driver_->state(); }
  virtual_engraver::HeadController& head() { return machine_->controller(); }
  formats::MarkRecord Record();
  std::vector<formats::BurntTick> Burnt() { return Record().ticks; }
  /// The fates of a mark, in order.
  std::vector<MarkFate> FatesOf(std::uint32_t mark) const;
  bool Has(std::uint32_t mark, MarkFate fate) const;

  bool permits = true;
  std::vector<MarkEvent> events;

 private:
  struct Wire;
  class End;
  void MakeMachine();
  void Plug();

  MachineSpec profile_;
  virtual_engraver::HeadOptions head_;
  std::filesystem::path record_;
  std::shared_ptr<Wire> wire_;
  std::chrono::nanoseconds now_{std::chrono::seconds(1)}, next_permit_{0};
  bool cut_ = false;
  std::unique_ptr<virtual_engraver::HeadMachine> machine_;
  std::unique_ptr<MarkDriver> driver_;
};

}  // namespace intaglio::drivers
