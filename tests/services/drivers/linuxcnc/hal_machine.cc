#include "tests/services/drivers/linuxcnc/hal_machine.h"

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/shm.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "tests/test_folder.h"

namespace intaglio::linuxcnc {
namespace {

bool WriteFile(const char* file, const std::string& text) {
  std::ofstream out(file);
  out << text << std::flush;
  return out.good();
}

// Root needs no user namespace; anybody else is root of one, mapped to himself.
bool Unshare() {
  if (unshare(CLONE_NEWIPC) == 0) return true;
  const std::string user = std::to_string(getuid()), group = std::to_string(getgid());
  if (unshare(CLONE_NEWUSER | CLONE_NEWIPC) != 0) return false;
  return WriteFile("/proc/self/uid_map", user + " " + user + " 1\n") &&
         WriteFile("/proc/self/setgroups", "deny") &&
         WriteFile("/proc/self/gid_map", group + " " + group + " 1\n");
}

// halrun takes every rtapi_app that it finds in /proc for its own. So HAL has process
// numbers of its own; with the first of them everything ends.
template <typename Exec>
[[noreturn]] void RunAsInit(const Exec& exec) {
  if (unshare(CLONE_NEWPID | CLONE_NEWNS) != 0) _exit(126);
  const pid_t init = fork();
  if (init == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr);
    mount("proc", "/proc", "proc", 0, nullptr);
    exec();
    _exit(127);
  }
  waitpid(init, nullptr, 0);
  _exit(0);
}

// LinuxCNC is for computers that are there for it alone. Where this user may, the threads
// of HAL, the driver and its test go before what the tests beside it compute; else HAL
// ends a run now and then, for the driver is late.
void GoBeforeOthers() {
  const sched_param first{.sched_priority = 1};
  sched_setscheduler(0, SCHED_FIFO, &first);
}

// What the killed HAL has left in this process's namespace.
void RemoveSharedMemory() {
  shm_info all{};
  const int last = shmctl(0, SHM_INFO, reinterpret_cast<shmid_ds*>(&all));
  for (int i = 0; i <= last; ++i) {
    shmid_ds segment{};
    if (const int id = shmctl(i, SHM_STAT, &segment); id >= 0)
      shmctl(id, IPC_RMID, nullptr);
  }
}

}  // namespace

std::string EnterNamespace() {
  if (access("/usr/bin/halrun", X_OK) != 0)
    return "halrun is missing: apt-get install linuxcnc-uspace";
  if (!Unshare()) return "this system permits no IPC namespace";
  GoBeforeOthers();
  return "";
}

HalTool::HalTool(const std::vector<std::string>& arguments, const std::string& output) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("pipe2 failed");
  std::vector<char*> argv;
  for (const std::string& argument : arguments)
    argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  child_ = fork();
  if (child_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    dup2(ends[0], 0);
    const int out = open(output.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    dup2(out, 1);
    execvp(argv[0], argv.data());
    _exit(127);
  }
  close(ends[0]);
  input_ = ends[1];
}

HalTool::~HalTool() {
  close(input_);
  kill(child_, SIGKILL);
  waitpid(child_, nullptr, 0);
}

void HalTool::Write(const std::string& text) const {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t count = write(input_, text.data() + done, text.size() - done);
    if (count < 0) throw std::runtime_error("a tool of HAL takes no more");
    done += static_cast<std::size_t>(count);
  }
}

HalMachine::HalMachine(std::filesystem::path folder, std::string serial_number,
                       std::filesystem::path axes, bool beam)
    : folder_(std::move(folder)),
      serial_number_(std::move(serial_number)),
      axes_(axes.empty() ? std::filesystem::path(INTAGLIO_SOURCE_DIR) /
                               "deploy/linuxcnc/simulated.hal"
                         : std::move(axes)),
      beam_(beam) {
  PowerOn();
}

HalMachine::~HalMachine() { PowerOff(); }

void HalMachine::PowerOn() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("pipe2 failed");
  const std::string start = std::string(INTAGLIO_SOURCE_DIR) + "/deploy/linuxcnc/start";
  const std::string log = (folder_ / "hal.log").string();
  std::filesystem::remove(folder_ / "identity");
  child_ = fork();
  if (child_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    dup2(ends[0], 0);
    const int out = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    dup2(out, 1);
    dup2(out, 2);
    RunAsInit([&] {
      execl(start.c_str(), "start", folder_.c_str(), "--serial-number",
            serial_number_.c_str(), "--axes", axes_.c_str(), beam_ ? "--beam" : nullptr,
            nullptr);
    });
  }
  close(ends[0]);
  input_ = ends[1];
  for (int i = 0; i < 1000; ++i) {
    if (std::filesystem::exists(folder_ / "identity")) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const std::string output = test::ContentOf(log);
  PowerOff();
  throw std::runtime_error("HAL does not start: " + output);
}

void HalMachine::Command(const std::string& command) {
  const std::string line = command + "\n";
  if (write(input_, line.data(), line.size()) != static_cast<ssize_t>(line.size()))
    throw std::runtime_error("HAL takes no command: " + command);
}

// A line of its log that is a number, whatever its prompt adds.
double HalMachine::ValueOf(const std::string& pin) {
  const auto log = folder_ / "hal.log";
  const auto before = std::filesystem::file_size(log);
  Command("getp " + pin);
  for (int i = 0; i < 500; ++i) {
    std::istringstream lines(test::ContentOf(log).substr(before));
    for (std::string line; std::getline(lines, line) && !lines.eof();) {
      while (line.starts_with("halcmd: ")) line.erase(0, 8);
      char* end = nullptr;
      const double value = std::strtod(line.c_str(), &end);
      if (!line.empty() && end == line.c_str() + line.size()) return value;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  throw std::runtime_error("HAL does not print " + pin);
}

void HalMachine::PowerOff() {
  if (child_ < 0) return;
  close(input_);
  // Everything in its process numbers ends with it.
  kill(child_, SIGKILL);
  waitpid(child_, nullptr, 0);
  child_ = -1;
  std::filesystem::remove(folder_ / "hal.log");
  std::filesystem::remove(folder_ / "identity");
  RemoveSharedMemory();
}

std::vector<std::uint64_t> HalMachine::RecordedTicks() const {
  std::ifstream in(folder_ / "pulses");
  std::vector<std::uint64_t> ticks;
  double x = 0, y = 0, z = 0;
  for (std::uint64_t tick = 0; in >> tick >> x >> y >> z;) ticks.push_back(tick);
  return ticks;
}

}  // namespace intaglio::linuxcnc
