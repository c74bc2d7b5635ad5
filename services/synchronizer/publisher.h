#pragma once

// What a cell that makes points publishes on the bus besides its task: the lamp's clock,
// the interlocks, the pulses.

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "services/drivers/interface/laser_controller.h"
#include "services/platform/bus/bus.h"
#include "services/platform/host/peers/machine_reporter.h"
#include "services/platform/host/safety/stop_latch.h"
#include "services/synchronizer/pulses/cell_names.h"
#include "services/synchronizer/pulses/pulse_schedule.h"

namespace intaglio::synchronizer {

class Publisher {
 public:
  /// `instance`: of the process, as in its health.
  Publisher(bus::Bus& bus, std::string cell, std::string instance);

  /// Pulse results are gathered; a batch goes out when it is full or 20 ms old.
  void BeginJob(const std::string& job_uid);
  void Add(const PulseResult& result);
  void Flush(std::chrono::nanoseconds now, bool all);
  /// The lamp's clock with every status of the controller in which more than the time has
  /// passed, and ten times a second; interlocks when they change and every 50 ms;
  /// what has changed of the machine for the job service.
  void PublishLaser(const drivers::LaserController& laser, const host::StopLatch& stop,
                    std::chrono::nanoseconds now);

 private:
  void PublishLampSync(const drivers::LaserController& laser,
                       std::chrono::nanoseconds now);
  void PublishInterlock(const drivers::LaserController& laser,
                        const host::StopLatch& stop, std::chrono::nanoseconds now);

  std::string cell_;
  bus::Writer<intaglio_PulseEventBatch> pulses_;
  bus::Writer<intaglio_LampSync> lamp_;
  bus::Writer<intaglio_Interlock> interlocks_;
  host::MachineReporter reporter_;

  std::string job_uid_;
  std::uint64_t pulse_number_ = 0;
  std::vector<std::uint64_t> tick_;
  std::vector<std::uint32_t> point_;
  std::vector<std::uint8_t> outcome_, reason_;
  std::chrono::nanoseconds next_pulses_{0};
  std::uint64_t published_number_ = 0;
  link::LaserStatus published_status_;
  std::chrono::nanoseconds next_status_{0};
  std::uint32_t published_interlocks_ = 0xffffffff;
  std::uint64_t published_stop_ = 0;
  drivers::Accessories published_accessories_;
  std::chrono::nanoseconds next_interlock_{0};
};

}  // namespace intaglio::synchronizer
