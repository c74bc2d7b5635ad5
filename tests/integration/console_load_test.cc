// A console whose clients are slow, many or broken: a stop is confirmed all the same.

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <iostream>
#include <thread>
#include <vector>

#include "tests/integration/console_shop.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using namespace intaglio::testing;
using test::Ask;
using test::WebAnswer;
using test::WebConnection;
using ::testing::HasSubstr;

class ConsoleUnderLoad : public ConsoleShop {
 protected:
  /// Pages that open the state and read nothing of it.
  void OpenSlowReaders(int count) {
    for (int i = 0; i < count; ++i) {
      slow_.emplace_back(port_, 4096);
      slow_.back().Send(test::Upgrade(port_, "/control", key_));
    }
  }
  /// Each on a connection of its own, which the console ends.
  void SendBrokenFrames() {
    using namespace std::string_literals;
    const std::string unmasked = "\x81\x02{}"s;
    const std::string huge = "\x81\xff\x7f\xff\xff\xff\xff\xff\xff\xff\x00\x00\x00\x00"s;
    const std::string reserved = "\xf1\x80\x00\x00\x00\x00"s;
    for (const std::string& frame : {unmasked, huge, reserved}) {
      WebConnection broken(port_);
      broken.Send(test::Upgrade(port_, "/control", key_));
      broken.ReadUntil("\r\n\r\n", 10s);
      broken.Send(frame);
      EXPECT_TRUE(broken.Ends(20s));
    }
  }
  /// The memory of the console.
  double MemoryMb() const {
    double size_pages = 0, resident_pages = 0;
    std::ifstream("/proc/" + std::to_string(console_->pid()) + "/statm") >> size_pages >>
        resident_pages;
    return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
  }
  std::vector<WebConnection> slow_;
};

double Share(std::vector<double> sorted, double ratio) {
  std::sort(sorted.begin(), sorted.end());
  return sorted[static_cast<std::size_t>(ratio * static_cast<double>(sorted.size() - 1))];
}

// A stop that is not confirmed is answered after a second, so each is confirmed by then.
// The job service is killed in between: no stop needs it.
TEST_F(ConsoleUnderLoad, EveryStopIsConfirmed) {
  EngraveSome();
  OpenSlowReaders(50);
  SendBrokenFrames();
  std::atomic<int> asked = 0;
  std::vector<double> stop_ms;
  {
    const std::jthread flood([&](const std::stop_token& end) {
      while (!end.stop_requested())
        asked += Ask(port_, {.path = "/api/v1/status", .key = key_}).status == 200;
    });
    for (int i = 0; i < 200; ++i) {
      if (i == 100) floor_.at(kJobService).Signal(SIGKILL);
      const WebAnswer stopped = Post("/api/v1/stop");
      ASSERT_EQ(stopped.status, 200) << stopped.body;
      EXPECT_THAT(stopped.body, HasSubstr("\n \"confirmed\": true")) << stopped.body;
      stop_ms.push_back(stopped.seconds * 1000);
    }
  }
  ExpectNothingFires();
  double load = 0;
  std::ifstream("/proc/loadavg") >> load;
  std::cout << "from the request to the confirmation by the machine, ms: median "
            << Share(stop_ms, 0.5) << ", p99 " << Share(stop_ms, 0.99) << ", largest "
            << Share(stop_ms, 1) << "; " << asked
            << " other requests were answered meanwhile; the console has " << MemoryMb()
            << " MB; load " << load << "\n";
  EXPECT_GT(MemoryMb(), 1);
  EXPECT_LT(MemoryMb(), 100);
  EXPECT_GT(asked, 20);
}

}  // namespace
}  // namespace intaglio
