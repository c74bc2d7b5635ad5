#pragma once

// A laser on an output of a motion controller as the synchronizer sees it: the rig of the
// controller's own driver, a LaserOutput in front of that driver, a line in memory, and
// the driver of the synchronizer.

#include <memory>
#include <string>

#include "services/drivers/laser_output.h"
#include "tests/services/drivers/laser_rig.h"
#include "tests/services/platform/link/faulty_line.h"

namespace intaglio::drivers {

/// Which of the two lines the checks cut.
enum class CutLineOf {
  kSynchronizer,  ///< between synchronizer and bridge: a process that hangs
  kController,    ///< between bridge and controller: a cable
};

class MotionOutputRig final : public LaserRig {
 public:
  /// `inner`: with the driver of the controller. `serial_number`: in the profile of the
  /// synchronizer; empty: any.
  MotionOutputRig(std::unique_ptr<LaserRig> inner, CutLineOf cut_line,
                  const std::string& serial_number);

  void CutLine(bool cut) override;
  void CutLineAfter(std::uint64_t bytes) override;
  void SwitchOff() override { inner_->SwitchOff(); }
  void SwitchOn() override { inner_->SwitchOn(); }
  void Set(Interlock interlock, bool holds) override { inner_->Set(interlock, holds); }
  std::uint64_t tick() override { return inner_->tick(); }
  std::vector<std::uint64_t> FiredTicks() override { return inner_->FiredTicks(); }
  std::uint8_t shutters() override { return inner_->shutters(); }
  bool lamp_on() override { return inner_->lamp_on(); }
  double rate_hz() const override { return inner_->rate_hz(); }
  double fast_rate_hz() const override { return inner_->fast_rate_hz(); }
  bool sees_cracks() const override { return inner_->sees_cracks(); }
  std::chrono::milliseconds disarm_time() const override {
    return inner_->disarm_time() + std::chrono::milliseconds(100);
  }
  // A silent synchronizer is noticed by the bridge, which closes the controller.
  std::string stated_violation(std::string_view check) const override {
    const bool of_a_cut = check.substr(0, 2) == "L7";
    return of_a_cut && cut_line_ == CutLineOf::kSynchronizer
               ? ""
               : inner_->stated_violation(check);
  }

  /// The bridge's process is killed, and another one comes; so with the synchronizer's.
  void KillBridge();
  void KillSynchronizer();

 private:
  class Ends;
  void AdvanceController() override;
  std::unique_ptr<link::ByteStream> Open();
  void NewHost();

  std::unique_ptr<LaserRig> inner_;
  CutLineOf cut_line_;
  std::string serial_number_;
  std::chrono::nanoseconds now_ = std::chrono::hours(2);
  std::shared_ptr<std::mt19937_64> random_ = std::make_shared<std::mt19937_64>(1);
  std::shared_ptr<link::FaultyPipe> to_bridge_ = std::make_shared<link::FaultyPipe>();
  std::shared_ptr<link::FaultyPipe> to_host_ = std::make_shared<link::FaultyPipe>();
  std::unique_ptr<LaserOutput> output_;
};

}  // namespace intaglio::drivers
