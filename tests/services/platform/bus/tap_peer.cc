// The other process of topic_tap_test: a writer in the same process announces no type.
//
//   tap_peer TAG topics CELL...         an empty sample of every topic in every cell,
//                                       every 10 ms
//   tap_peer TAG instance NAME COUNT    waits for a reader of ServiceHealth, writes COUNT
//                                       samples of NAME, 1 ms apart, disposes it, and
//                                       waits

#include <chrono>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "services/platform/bus/bus.h"
#include "services/platform/bus/samples.h"
#include "services/platform/bus/topics.h"

namespace {

using namespace intaglio;
using namespace std::chrono_literals;

void WriteTopics(bus::Bus& bus, const std::vector<std::string>& cells) {
  std::vector<std::function<void()>> writes;
  for (const std::string& cell : cells) {
    bus::ForEachTopic([&](const auto& topic) {
      using Sample = typename std::remove_cvref_t<decltype(topic)>::Sample;
      auto writer = std::make_shared<bus::Writer<Sample>>(bus, topic, cell);
      writes.push_back([writer] { (void)writer->Write(Sample{}); });
    });
  }
  for (;;) {
    for (const auto& write : writes) write();
    std::this_thread::sleep_for(10ms);
  }
}

void WriteInstance(bus::Bus& bus, const std::string& name, int count) {
  bus::Writer<intaglio_ServiceHealth> writer(bus, bus::kServiceHealth);
  while (writer.matched_count() == 0) std::this_thread::sleep_for(1ms);
  intaglio_ServiceHealth health{};
  health.instance = bus::Borrow(name);
  for (health.steady_ns = 0; health.steady_ns < count; ++health.steady_ns) {
    (void)writer.Write(health);
    std::this_thread::sleep_for(1ms);
  }
  (void)writer.Dispose(health);
  std::this_thread::sleep_for(60s);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) return 2;
  bus::BusOptions options;
  options.tag = argv[1];
  bus::Bus bus(options);
  const std::vector<std::string> arguments(argv + 3, argv + argc);
  if (argv[2] == std::string("topics")) WriteTopics(bus, arguments);
  if (argv[2] == std::string("instance") && arguments.size() == 2) {
    WriteInstance(bus, arguments[0], std::atoi(arguments[1].c_str()));
  }
  return 2;
}
