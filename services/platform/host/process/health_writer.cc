#include "services/platform/host/process/health_writer.h"

#include <unistd.h>

#include "services/platform/bus/samples.h"
#include "services/platform/host/peers/identity_role.h"
#include "services/platform/host/process/log.h"
#include "services/platform/host/version/wire_version.h"

namespace intaglio::host {
namespace {

using bus::Borrow;
constexpr std::chrono::milliseconds kHealthPeriod{600};

std::string HostName() {
  char name[256] = "localhost";
  gethostname(name, sizeof name - 1);
  return name;
}

}  // namespace

HealthWriter::HealthWriter(bus::Bus& bus, intaglio_ServiceRole role,
                           const std::string& name)
    : bus_(bus),
      role_(role),
      writer_(bus, bus::kServiceHealth),
      host_(HostName()),
      instance_(InstanceName(name, host_, getpid(), bus.participant_name())) {}

bool HealthWriter::Set(intaglio_HealthState state, const std::string& job_uid,
                       const std::string& message) {
  if (state == state_ && job_uid == job_uid_ && message == message_) return false;
  state_ = state;
  job_uid_ = job_uid;
  message_ = message;
  Publish();
  return true;
}

void HealthWriter::Publish() {
  intaglio_ServiceHealth sample{};
  sample.instance = Borrow(instance_);
  sample.role = role_;
  sample.state = state_;
  sample.host = Borrow(host_);
  sample.pid = getpid();
  sample.cell = Borrow(bus_.options().cell);
  sample.job_uid = Borrow(job_uid_);
  sample.version = Borrow(WireVersion());
  sample.message = Borrow(message_);
  sample.steady_ns = Clock::now().time_since_epoch().count();
  if (auto written = writer_.Write(sample); !written)
    LogWarning("health: {}", written.error().message);
  next_publication_ = Clock::now() + kHealthPeriod;
}

void HealthWriter::Turn(Clock::time_point now) {
  if (now >= next_publication_) Publish();
}

}  // namespace intaglio::host
