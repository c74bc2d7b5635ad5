#include "services/cli/recordings/recording_export.h"

#include <gmock/gmock.h>

#include "engrave/formats/point_file.h"
#include "idl/laser.h"
#include "services/platform/recording/conventions.h"
#include "services/platform/recording/mcap_writer.h"
#include "tests/services/platform/recording/status_samples.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

using ::testing::ElementsAre;

// The fields of a PulseEventBatch that are read, in words of four bytes.
constexpr char kPulsesIdl[] =
    "module intaglio { @final struct PulseEventBatch { string job_uid; "
    "sequence<uint32> tick; sequence<uint32> point; sequence<uint32> outcome; }; };";

constexpr std::uint32_t kJob = 0x00626f6a, kTwo = 0x006f7774;  // "job", "two"

/// One pulse of the job "job", or of another one.
recording::Bytes PulseOf(std::uint32_t tick, std::uint32_t point, std::uint32_t outcome,
                         std::uint32_t job = kJob) {
  return recording::TextAsCdr({4, job, 1, tick, 1, point, 1, outcome});
}

std::uint16_t AddPulses(recording::McapWriter& writer) {
  recording::Channel channel = recording::ChannelOf({"PulseEventBatch",
                                                     "intaglio::PulseEventBatch",
                                                     false,
                                                     "cell",
                                                     recording::SampleKind::kValue,
                                                     false,
                                                     {}});
  channel.schema_id =
      writer.AddSchema("intaglio::PulseEventBatch", recording::kOmgIdl, kPulsesIdl);
  return writer.AddChannel(channel);
}

// By a person's consent a point is fired again, and the next life of the synchronizer may
// report a point that an earlier life reported: the newest crack of each counts.
TEST(RecordingExport, APointThatIsReportedTwiceIsOneCrack) {
  const auto folder = test::FreshFolder();
  auto writer = recording::McapWriter::Create(folder / "a.mcap", {}).value();
  const std::uint16_t id = AddPulses(writer);
  std::uint32_t number = 0;
  for (const auto& [tick, point, outcome] :
       {std::tuple{20u, 0u, intaglio_PULSE_MADE},
        {21u, 1u, intaglio_PULSE_UNCERTAIN},
        {22u, 2u, intaglio_PULSE_UNCERTAIN},
        {23u, 3u, intaglio_PULSE_SKIPPED},
        {20u, 0u, intaglio_PULSE_MADE},     // reported again
        {10u, 1u, intaglio_PULSE_MADE},     // after another power-up
        {11u, 2u, intaglio_PULSE_SKIPPED},  // opened again, and not fired
        {12u, 3u, intaglio_PULSE_MADE}}) {
    const recording::Bytes payload =
        PulseOf(tick, point, static_cast<std::uint32_t>(outcome));
    ASSERT_TRUE(writer.Write(
        recording::MessageView{id, number, 1000 + number, 1000 + number, payload}));
    ++number;
  }
  ASSERT_TRUE(writer.Close());
  formats::PointTable path;
  path.points_mm = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(3, 0, 0)};
  ASSERT_TRUE(formats::WritePly(folder / "path.ply", path));
  const auto reader = recording::McapReader::Open(folder / "a.mcap").value();
  const auto exported =
      ExportCracks(reader, "", folder / "path.ply", folder / "cracks.ply");
  ASSERT_TRUE(exported) << exported.error().message;
  const auto cracks = formats::ReadPly(folder / "cracks.ply");
  ASSERT_TRUE(cracks) << cracks.error().message;
  EXPECT_THAT(*cracks->Find<std::uint32_t>("point"), ElementsAre(1, 3, 0));
  EXPECT_THAT(*cracks->Find<double>("tick"), ElementsAre(10, 12, 20));
}

TEST(RecordingExport, AJobIsNamedByItsNumberAsEverywhere) {
  const auto folder = test::FreshFolder();
  auto writer = recording::McapWriter::Create(folder / "a.mcap", {}).value();
  const std::uint16_t id = AddPulses(writer);
  std::uint32_t number = 0;
  // "1-a", "2-a", "2-b"
  for (const std::uint32_t job : {0x00612d31u, 0x00612d32u, 0x00622d32u}) {
    const recording::Bytes payload = PulseOf(20, 0, intaglio_PULSE_MADE, job);
    ASSERT_TRUE(writer.Write(
        recording::MessageView{id, number, 1000 + number, 1000 + number, payload}));
    ++number;
  }
  ASSERT_TRUE(writer.Close());
  formats::PointTable path;
  path.points_mm = {Vec3(0, 0, 0)};
  ASSERT_TRUE(formats::WritePly(folder / "path.ply", path));
  const auto reader = recording::McapReader::Open(folder / "a.mcap").value();
  const auto export_of = [&](const std::string& job) {
    return ExportCracks(reader, job, folder / "path.ply", folder / "cracks.ply");
  };
  EXPECT_TRUE(export_of("1"));
  EXPECT_TRUE(export_of("2-b"));
  const auto two_shops = export_of("2");
  ASSERT_FALSE(two_shops);
  EXPECT_EQ(two_shops.error().message,
            "the recording has the points of 2 jobs, 2-a, 2-b: name one with --job");
}

TEST(RecordingExport, OfSeveralJobsOneHasToBeNamed) {
  const auto folder = test::FreshFolder();
  auto writer = recording::McapWriter::Create(folder / "a.mcap", {}).value();
  const std::uint16_t id = AddPulses(writer);
  std::uint32_t number = 0;
  for (const std::uint32_t job : {kJob, kTwo}) {
    const recording::Bytes payload = PulseOf(20, 0, intaglio_PULSE_MADE, job);
    ASSERT_TRUE(writer.Write(
        recording::MessageView{id, number, 1000 + number, 1000 + number, payload}));
    ++number;
  }
  ASSERT_TRUE(writer.Close());
  formats::PointTable path;
  path.points_mm = {Vec3(0, 0, 0)};
  ASSERT_TRUE(formats::WritePly(folder / "path.ply", path));
  const auto reader = recording::McapReader::Open(folder / "a.mcap").value();
  const auto export_of = [&](const std::string& job) {
    return ExportCracks(reader, job, folder / "path.ply", folder / "cracks.ply");
  };
  const auto any = export_of("");
  ASSERT_FALSE(any.has_value()) << "one of them without a word";
  EXPECT_EQ(any.error().message,
            "the recording has the points of 2 jobs, job, two: name one with --job");
  const auto wrong = export_of("three");
  ASSERT_FALSE(wrong.has_value()) << "an empty file and exit code 0";
  EXPECT_EQ(wrong.error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(std::filesystem::exists(folder / "cracks.ply"));
  EXPECT_TRUE(export_of("two").has_value());
}

}  // namespace
}  // namespace intaglio::cli
