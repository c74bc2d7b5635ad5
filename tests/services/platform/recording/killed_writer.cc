// Writes a recording as fast as it may until it is killed: 32-byte messages with the time
// of their writing, 100 us apart, and a large one now and then.
//
//   killed_writer FILE

#include <chrono>
#include <cstdlib>
#include <thread>

#include "services/platform/recording/mcap_writer.h"

int main(int argc, char** argv) {
  using namespace intaglio::recording;
  using namespace std::chrono_literals;
  if (argc != 2) return 2;
  WriterOptions options{.library = "killed_writer"};
  options.chunk_ns = 20'000'000;
  auto writer = McapWriter::Create(argv[1], options);
  if (!writer) return 1;
  const auto small = writer->AddChannel({0, 0, "small", "cdr", {}}, Lane::kSmall);
  const auto large = writer->AddChannel({0, 0, "large", "cdr", {}}, Lane::kLarge);
  const Bytes little(32), much(300'000);
  for (std::uint32_t i = 0;; ++i) {
    const auto now = static_cast<std::uint64_t>(
        std::chrono::system_clock::now().time_since_epoch() / 1ns);
    const bool is_large = i % 100 == 99;
    const MessageView message{is_large ? large : small, i, now, now,
                              is_large ? much : little};
    if (!writer->Write(message) || !writer->FlushIfOld(now)) return 1;
    std::this_thread::sleep_for(100us);
  }
}
