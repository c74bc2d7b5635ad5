#include "tests/services/virtual_engraver/engraver_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "services/platform/link/endpoint.h"
#include "services/virtual_engraver/truth/truth_file.h"
#include "tests/patience.h"

namespace intaglio::virtual_engraver {
namespace {

constexpr const char* kPlain =
    "stage { first_order_lag_s: 0 } laser { warm_up_s: 0 } block { refractive_index: 1 }";

std::vector<std::string> Arguments(const std::filesystem::path& folder,
                                   const std::string& truth_text,
                                   const std::vector<std::string>& more, bool over_tcp) {
  const std::string free_port = "tcp:127.0.0.1:0";
  const std::filesystem::path file = folder / "truth.textproto";
  auto truth = ParseTruth(kPlain, "plain").value();
  if (const auto changes = ParseTruth(truth_text, "changes")) {
    Replace(*changes, truth);
    (void)WriteTruthFile(file, truth);
  } else {
    std::ofstream(file) << truth_text;
  }
  std::vector<std::string> all = {
      "--truth",        file,
      "--laser-line",   over_tcp ? free_port : (folder / "laser").string(),
      "--motion-line",  over_tcp ? free_port : (folder / "motion").string(),
      "--glass-record", folder / "glass.rec",
      "--panel",        folder / "panel"};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

/// A socket's path has room for 107 characters; through the folder's descriptor every
/// path is short.
int ConnectTo(const std::filesystem::path& folder, const std::string& name) {
  const int folder_fd = open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  const std::string path = "/proc/self/fd/" + std::to_string(folder_fd) + "/" + name;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const bool connected =
      connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  close(folder_fd);
  if (connected) return fd;
  close(fd);
  return -1;
}

}  // namespace

EngraverProcess::EngraverProcess(const std::filesystem::path& folder,
                                 const std::string& truth,
                                 const std::vector<std::string>& more_options,
                                 bool over_tcp)
    : folder_(folder),
      over_tcp_(over_tcp),
      program_(intaglio::testing::Program("virtual-engraver"),
               Arguments(folder, truth, more_options, over_tcp),
               folder / "engraver.log") {}

bool EngraverProcess::AwaitReady() {
  return intaglio::testing::Eventually(
      [this] { return program_.Output().find("ready ") != std::string::npos; },
      std::chrono::seconds(5));
}

std::string EngraverProcess::DeviceOf(const std::string& line) const {
  if (!over_tcp_) return (folder_ / line).string();
  const std::string output = program_.Output(), key = line + "=";
  const auto at = output.find(key);
  if (at == std::string::npos) return {};
  const auto begin = at + key.size();
  return output.substr(begin, output.find_first_of(" \n", begin) - begin);
}

std::string EngraverProcess::Ask(const std::string& command) const {
  const int fd = ConnectTo(folder_, "panel");
  if (fd < 0) return {};
  const std::string line = command + "\n";
  std::string answer;
  if (send(fd, line.data(), line.size(), MSG_NOSIGNAL) > 0) {
    pollfd readable{fd, POLLIN, 0};
    char byte = 0;
    while (poll(&readable, 1, 1000) > 0 && read(fd, &byte, 1) == 1 && byte != '\n')
      answer += byte;
  }
  close(fd);
  return answer;
}

std::string EngraverProcess::StatusOf(const std::string& name) const {
  const std::string status = Ask("status"), key = '"' + name + "\": ";
  const auto at = status.find(key);
  if (at == std::string::npos) return {};
  const auto begin = at + key.size();
  return status.substr(begin, status.find_first_of(",}", begin) - begin);
}

EngravingHost::EngravingHost(const EngraverProcess& engraver)
    : laser_(link::EndpointOpener(engraver.laser_line(), 115200), link::MonotonicClock()),
      motion_(link::EndpointOpener(engraver.motion_line(), 115200),
              link::MonotonicClock()) {}

void EngravingHost::Poll() {
  const auto take = [this](std::uint8_t type, std::span<const std::byte> payload) {
    received_.Receive(type, payload);
  };
  laser_.Poll(take);
  motion_.Poll(take);
}

bool EngravingHost::Until(const std::function<bool()>& condition,
                          std::chrono::milliseconds bound) {
  const test::Patience patience(bound);
  for (;;) {
    Poll();
    if (condition()) return true;
    if (patience.over()) return false;
    pollfd fds[] = {{laser_.fd(), POLLIN, 0}, {motion_.fd(), POLLIN, 0}};
    poll(fds, 2, 5);
  }
}

bool EngravingHost::Connect() {
  return Until([this] {
    return laser_.up() && motion_.up() && !received_.laser_identities.empty() &&
           !received_.motion_identities.empty();
  });
}

bool EngravingHost::Send(link::LaserFrame type, const link::Bytes& payload) {
  return Until([this] { return laser_.CanSend(); }) &&
         laser_.Send(static_cast<std::uint8_t>(type), payload).has_value();
}

bool EngravingHost::Send(link::MotionFrame type, const link::Bytes& payload) {
  return Until([this] { return motion_.CanSend(); }) &&
         motion_.Send(static_cast<std::uint8_t>(type), payload).has_value();
}

bool EngravingHost::OpenShutterAndLamp() {
  return Send(link::LaserFrame::kLampCommand,
              Encode(link::LampCommand{
                  true, received_.laser_identities.empty()
                            ? 100
                            : received_.laser_identities.back().rates_hz.front()})) &&
         Send(link::LaserFrame::kShutterCommand, Encode(link::ShutterCommand{1}));
}

std::uint64_t EngravingHost::TickNow() {
  const std::size_t before = received_.laser_statuses.size();
  if (!Send(link::LaserFrame::kLaserStatusRequest) ||
      !Until([&] { return received_.laser_statuses.size() > before; })) {
    return 0;
  }
  return received_.laser_statuses.back().tick;
}

ForkedHost::ForkedHost(const std::function<void()>& work) : pid_(fork()) {
  if (pid_ != 0) return;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  work();
  _exit(0);
}

ForkedHost::~ForkedHost() {
  Signal(SIGKILL);
  waitpid(pid_, nullptr, 0);
}

void ForkedHost::Signal(int number) const {
  if (pid_ > 0) kill(pid_, number);
}

}  // namespace intaglio::virtual_engraver
