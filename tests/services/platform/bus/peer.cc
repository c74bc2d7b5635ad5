// The other process of the tests: joins with the given tag, announces itself, takes part
// in one flow if asked to, and waits to be killed.
//
//   bus_peer TAG health INSTANCE [ROLE]
//   bus_peer TAG consume STREAM WINDOW DELAY_US   opens the stream, takes slowly,
//                                                 and announces itself every 2 ms
//   bus_peer TAG count INSTANCE   its health's pid is how many PulseEventBatches came
//   bus_peer TAG deaf INSTANCE    takes a first PulseEventBatch, then receives nothing
//   any
//                                 more, so that it acknowledges nothing, and stays alive

#include <dds/dds.h>

#include <chrono>
#include <cstdlib>
#include <iostream>
#include <string>
#include <thread>

#include "services/platform/bus/bus_entities.h"
#include "services/platform/bus/flow.h"
#include "services/platform/bus/samples.h"

namespace {

using namespace intaglio::bus;
using namespace std::chrono_literals;

// The monotonic clock is the same for all processes of a host.
void Announce(Bus& bus, const std::string& instance, std::chrono::milliseconds period) {
  Writer<intaglio_ServiceHealth> writer(bus, kServiceHealth);
  intaglio_ServiceHealth health{};
  health.instance = Borrow(instance);
  for (;;) {
    health.steady_ns = std::chrono::steady_clock::now().time_since_epoch().count();
    (void)writer.Write(health);
    std::this_thread::sleep_for(period);
  }
}

void Consume(Bus& bus, const std::string& stream, std::uint32_t window,
             std::chrono::microseconds delay) {
  Reader<intaglio_ModelChunk> reader(bus, kModelChunk);
  CreditGrantor credit(bus, "peer");
  WaitSet wait(bus);
  wait.Attach(reader);
  (void)credit.Open(stream, reader.guid(), window);
  std::uint64_t expected = 0;
  for (bool last = false; !last;) {
    (void)wait.Wait(1000ms);
    reader.Take([&](const intaglio_ModelChunk& chunk) {
      if (chunk.sequence_number != expected++) std::exit(3);
      std::this_thread::sleep_for(delay);
      last = chunk.last;
      (void)credit.Consumed(stream, expected, last);
    });
  }
  std::this_thread::sleep_for(10s);
}

void Count(Bus& bus, const std::string& instance) {
  Reader<intaglio_PulseEventBatch> reader(bus, kPulseEventBatch);
  Writer<intaglio_ServiceHealth> writer(bus, kServiceHealth);
  intaglio_ServiceHealth health{};
  health.instance = Borrow(instance);
  for (;;) {
    health.pid += reader.Take([](const intaglio_PulseEventBatch&) {});
    (void)writer.Write(health);
    std::this_thread::sleep_for(20ms);
  }
}

void BecomeDeaf(Bus& bus, const std::string& instance) {
  Reader<intaglio_PulseEventBatch> reader(bus, kPulseEventBatch);
  Writer<intaglio_ServiceHealth> writer(bus, kServiceHealth);
  intaglio_ServiceHealth health{};
  health.instance = Borrow(instance);
  while (health.pid == 0) {
    health.pid = reader.Take([](const intaglio_PulseEventBatch&) {});
    std::this_thread::sleep_for(20ms);
  }
  (void)writer.Write(health);
  (void)dds_domain_set_deafmute(bus.entities().control, true, false, DDS_INFINITY);
  for (;;) std::this_thread::sleep_for(1s);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) return 2;
  BusOptions options;
  options.tag = argv[1];
  if (argv[2] == std::string("health") && argc == 5) options.roles = {argv[4]};
  Bus bus(options);
  if (argv[2] == std::string("health")) Announce(bus, argv[3], 200ms);
  if (argv[2] == std::string("count")) Count(bus, argv[3]);
  if (argv[2] == std::string("deaf")) BecomeDeaf(bus, argv[3]);
  if (argv[2] == std::string("consume") && argc == 6) {
    std::thread([&bus] { Announce(bus, "consumer", 2ms); }).detach();
    Consume(bus, argv[3], static_cast<std::uint32_t>(std::atoi(argv[4])),
            std::chrono::microseconds(std::atoi(argv[5])));
    std::_Exit(0);
  }
  return 2;
}
