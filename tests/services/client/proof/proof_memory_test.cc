// The memory that a proof takes, in bytes a point: the slope between two plans, so that
// what does not grow with them, such as the canvas of a picture, is left out.

#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <fstream>

#include "engrave/formats/glass_record.h"
#include "engrave/formats/journal_file.h"
#include "engrave/formats/point_file.h"
#include "services/client/proof/proof_folder.h"
#include "tests/peak_memory.h"
#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;
using formats::JournalKind;

constexpr double kStepMm = 0.1;
constexpr std::uint32_t kPowerUp = 7;
constexpr std::size_t kRow = 200, kLayer = kRow * kRow;

/// Layers from below, 20 mm wide.
PointList PlanOf(std::size_t count) {
  PointList plan_mm;
  plan_mm.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    plan_mm.emplace_back(kStepMm * static_cast<double>(i % kRow + 1),
                         kStepMm * static_cast<double>(i % kLayer / kRow + 1),
                         kStepMm * static_cast<double>(i / kLayer + 1));
  }
  return plan_mm;
}

FrozenJob Job() {
  FrozenJob frozen;
  JobSpec& job = *frozen.mutable_job();
  job.mutable_discretization()->set_min_spacing_mm(kStepMm);
  job.mutable_laser()->set_rate_hz(100);
  job.mutable_laser()->add_channels(1);
  Vector3& size = *job.mutable_block()->mutable_size_mm();
  size.set_x(21);
  size.set_y(21);
  size.set_z(21);
  frozen.mutable_machine()->set_position_tolerance_um(20);
  frozen.mutable_optics()->set_cone_tangent(0.1);
  return frozen;
}

template <typename Bytes>
void Put(const Bytes& bytes, std::ofstream& out) {
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
}

void WriteJournal(const fs::path& file, const PointList& plan_mm) {
  std::ofstream out(file, std::ios::binary);
  Put(formats::EncodeJournalHeader({plan_mm.size(), 1}), out);
  formats::JournalRecord record;
  record.kind = JournalKind::kSession;
  record.point = kPowerUp;
  Put(formats::EncodeJournalRecord(record), out);
  for (record.point = 0; record.point < plan_mm.size(); ++record.point) {
    record.tick = 10 + record.point;
    record.kind = JournalKind::kIntent;
    record.outcome = formats::PointOutcome::kNone;
    Put(formats::EncodeJournalRecord(record), out);
    record.kind = JournalKind::kOutcome;
    record.outcome = formats::PointOutcome::kMade;
    Put(formats::EncodeJournalRecord(record), out);
  }
}

/// A job of so many points, all made, beside the record of its glass.
fs::path MakeFolder(std::size_t count) {
  const fs::path folder = test::FreshFolder();
  const PointList plan_mm = PlanOf(count);
  std::string json;
  EXPECT_TRUE(google::protobuf::util::MessageToJsonString(Job(), &json).ok());
  std::ofstream(folder / "job.json") << json;
  WriteJournal(folder / "journal.bin", plan_mm);
  std::ofstream glass(folder / "glass.rec", std::ios::binary);
  Put(formats::EncodeGlassHeader({Vec3(21, 21, 21), 1.5, 0.1, kPowerUp}), glass);
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<std::byte> bytes;
    formats::AppendGlassCrack({10 + i, plan_mm[i], 30, 0, true}, bytes);
    Put(bytes, glass);
  }
  const std::vector<std::uint32_t> source(count, 0);
  EXPECT_TRUE(
      formats::WritePly(folder / "path.ply", {plan_mm, {{"source", source}}, {}}));
  return folder;
}

/// Reads the files of a folder and writes its report and picture.
std::optional<std::uint64_t> PeakBytes(std::size_t count) {
  const fs::path folder = MakeFolder(count);
  const auto bytes = test::PeakBytesOf([&] {
    const auto proved = CompleteFolder({folder, folder, false});
    ASSERT_TRUE(proved) << proved.error().message;
    EXPECT_EQ(proved->report.points().made(), count);
    EXPECT_EQ(proved->report.evidence(), "glass");
    EXPECT_FALSE(proved->not_written);
  });
  fs::remove_all(folder);
  return bytes;
}

// At the most are in memory at once: the plan (24 bytes a point and a mask), the cracks
// (33) and the history (24); or the first two, the tree of the plan (18) and its counts
// (8). It is half of what copies of plan and cracks take beside them, or a journal's
// records.
TEST(ProofMemory, OfAPointIsBelow100Bytes) {
  constexpr std::size_t kFew = 100'000, kMany = 500'000;
  const auto few = PeakBytes(kFew), many = PeakBytes(kMany);
  if (!few || !many) GTEST_SKIP() << "the memory of this process cannot be measured";
  EXPECT_LT(static_cast<double>(*many - *few) / (kMany - kFew), 100);
}

}  // namespace
}  // namespace intaglio::client
