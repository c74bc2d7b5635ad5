#pragma once

// A laser driver that passes everything on to another one: what a test changes of a good
// driver is all that differs.

#include <memory>
#include <utility>

#include "services/drivers/interface/laser_controller.h"

namespace intaglio::drivers {

class LaserWrapper : public LaserController {
 public:
  explicit LaserWrapper(std::unique_ptr<LaserController> inner)
      : inner_(std::move(inner)) {}
  void Poll(const ReportSink& sink, const PastSink& past) override {
    inner_->Poll(sink, past);
  }
  bool up() const override { return inner_->up(); }
  bool CanSend() const override { return inner_->CanSend(); }
  bool taken_over() const override { return inner_->taken_over(); }
  const std::string& message() const override { return inner_->message(); }
  const std::string& refusal() const override { return inner_->refusal(); }
  int fd() const override { return inner_->fd(); }
  const link::LaserIdentity& identity() const override { return inner_->identity(); }
  const link::LaserStatus& status() const override { return inner_->status(); }
  std::uint64_t status_number() const override { return inner_->status_number(); }
  std::chrono::nanoseconds status_at() const override { return inner_->status_at(); }
  std::uint64_t session() const override { return inner_->session(); }
  bool disarmed() const override { return inner_->disarmed(); }
  Status Lamp(bool on, double rate_hz) override { return inner_->Lamp(on, rate_hz); }
  Status OpenShutters(std::uint8_t mask) override { return inner_->OpenShutters(mask); }
  Status Arm(const link::ArmWindow& window) override { return inner_->Arm(window); }
  Status Disarm() override { return inner_->Disarm(); }
  Status Reset() override { return inner_->Reset(); }
  Status Stop() override { return inner_->Stop(); }
  Status RequestStatus() override { return inner_->RequestStatus(); }
  bool RequestPast(std::uint64_t first_tick, std::uint16_t count) override {
    return inner_->RequestPast(first_tick, count);
  }

 protected:
  std::unique_ptr<LaserController> inner_;
};

}  // namespace intaglio::drivers
