#include "services/reference_controller/host_line.h"

#include <poll.h>

#include <utility>
#include <vector>

#include "engrave/core/try.h"
#include "services/platform/link/serial_port.h"

namespace intaglio::reference_controller {

Result<HostLine> HostLine::Open(
    HostLineOptions options, std::function<void(std::unique_ptr<link::ByteStream>)> plug,
    std::function<bool()> is_plugged) {
  HostLine line;
  line.options_ = std::move(options);
  line.plug_in_ = std::move(plug);
  line.is_plugged_ = std::move(is_plugged);
  const std::string& device = line.options_.device;
  if (device.starts_with(kSerial)) {
    line.port_ = device.substr(kSerial.size());
    INTAGLIO_TRY(line.OpenPort());
    return line;
  }
  line.plug_ =
      INTAGLIO_TRY(virtual_engraver::OpenMachineLine(device, line.options_.name));
  line.plug_in_(line.plug_->MachineEnd());
  return line;
}

std::string HostLine::device() const { return plug_ ? plug_->device() : port_; }

void HostLine::Renew() {
  if (plug_ && plug_->HostHasGone()) plug_in_(plug_->MachineEnd());
  const auto now = std::chrono::steady_clock::now();
  if (plug_ || is_plugged_() || now < next_open_) return;
  next_open_ = now + std::chrono::milliseconds(500);
  (void)OpenPort();
}

void HostLine::WaitFor(std::chrono::nanoseconds time) const {
  std::vector<pollfd> lines;
  if (plug_) {
    for (const int fd : plug_->descriptors()) lines.push_back({fd, POLLIN, 0});
  } else if (is_plugged_()) {
    lines.push_back({fd_, POLLIN, 0});
  }
  const timespec timeout{0, static_cast<long>(time.count())};
  ppoll(lines.data(), lines.size(), &timeout, nullptr);
}

Status HostLine::OpenPort() {
  auto opened = INTAGLIO_TRY(link::OpenSerialPort(port_, options_.baud));
  fd_ = opened->fd();
  plug_in_(std::move(opened));
  return {};
}

}  // namespace intaglio::reference_controller
