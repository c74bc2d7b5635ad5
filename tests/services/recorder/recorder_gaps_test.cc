// What was lost on its way to the recorder is in its file.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <string>

#include "services/platform/bus/samples.h"
#include "services/platform/recording/bulk.h"
#include "tests/services/platform/bus/child_program.h"
#include "tests/services/platform/bus/private_bus.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using recording::McapReader;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::uint64_t MessageCount(const std::filesystem::path& file) {
  const auto reader = McapReader::Open(file);
  return reader ? reader->contents().statistics.message_count : 0;
}

/// What a command of `intaglio` prints.
std::string OutputOf(const std::string& arguments) {
  const std::string command = INTAGLIO_BIN_DIR "/intaglio " + arguments + " 2>&1";
  FILE* out = popen(command.c_str(), "r");
  std::string text;
  std::array<char, 4096> part;
  for (std::size_t size = 0; (size = std::fread(part.data(), 1, part.size(), out)) > 0;)
    text.append(part.data(), size);
  pclose(out);
  return text;
}

TEST(RecorderGaps, AreMissingMessagesOfTheRecording) {
  const auto file = test::FreshFolder() / "a.mcap";
  test::ChildProgram recorder(
      INTAGLIO_BIN_DIR "/intaglio-recorder",
      {"--tag", test::PrivateTag(), "--out", file.string(), "--topic", "Alarm"});
  bus::Bus bus(test::PrivateBusOptions());
  bus::Writer<intaglio_Alarm> writer(bus, bus::kAlarm);
  std::uint64_t number = 3;
  const auto send = [&] {
    intaglio_Alarm alarm{};
    alarm.instance = bus::Borrow("synchronizer");
    alarm.sequence_number = number++;
    ASSERT_TRUE(writer.Write(alarm));
  };
  // What was sent before the recorder came is not missing.
  ASSERT_TRUE(test::Eventually([&] { return send(), MessageCount(file) > 0; }, 20s));
  number += 3;
  send();
  send();
  number += 10;
  send();
  ASSERT_TRUE(writer.WaitForAcknowledgements(5s));
  recorder.Signal(SIGTERM);
  EXPECT_EQ(recorder.ExitCode(), 0);
  const auto reader = McapReader::Open(file);
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_THAT(recording::MissingSentences(*reader),
              ElementsAre(AllOf(HasSubstr("13 messages of Alarm are missing"),
                                HasSubstr("sequence numbers"))));
  const std::string name = file.string();
  EXPECT_THAT(OutputOf("recording info " + name),
              AllOf(HasSubstr("13 messages are missing in it"),
                    HasSubstr("Alarm: 13 messages, gaps in their sequence numbers")));
  for (const std::string& command :
       {"recording list " + name, "recording list --json " + name,
        "recording export " + name + " --out " + name + ".jsonl",
        "replay " + name + " --fast --tag " + test::PrivateTag(),
        "replay " + name + " --against sorter"}) {
    EXPECT_THAT(OutputOf(command), HasSubstr("13 messages of Alarm are missing: gaps"))
        << command;
  }
}

}  // namespace
}  // namespace intaglio
