#include "services/virtual_engraver/glass.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <cmath>
#include <limits>

#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio::virtual_engraver {
namespace {
namespace fs = std::filesystem;

const formats::GlassHeader kHeader = {Vec3(80, 60, 40), 1.52, 0.124};

fs::path RecordOfThisTest() { return test::FreshFolder() / "glass.rec"; }

formats::GlassCrack Crack(std::uint64_t tick) {
  const double t = static_cast<double>(tick);
  return {tick, Vec3(t / 3, -t, 0.1 * t), 30, static_cast<std::uint8_t>(tick % 4), true};
}

void ExpectSame(const formats::GlassCrack& got, const formats::GlassCrack& expected) {
  EXPECT_EQ(got.tick, expected.tick);
  EXPECT_EQ(got.position_mm, expected.position_mm);
  EXPECT_EQ(got.pulse_energy_mj, expected.pulse_energy_mj);
  EXPECT_EQ(got.channel, expected.channel);
  EXPECT_EQ(got.in_glass, expected.in_glass);
}

TEST(Glass, RecordsEveryCrackWithTickAndPosition) {
  const fs::path file = RecordOfThisTest();
  auto glass = Glass::Create(file, kHeader);
  ASSERT_TRUE(glass.has_value());
  for (std::uint64_t tick = 1; tick <= 5000; ++tick) {
    glass->Add(Crack(tick));
    if (tick % 700 == 0) {
      ASSERT_TRUE(glass->Flush().has_value());
    }
  }
  ASSERT_TRUE(glass->Flush().has_value());
  EXPECT_EQ(glass->crack_count(), 5000u);
  const auto record = formats::ReadGlassRecord(file);
  ASSERT_TRUE(record.has_value());
  EXPECT_EQ(record->header.block_size_mm, kHeader.block_size_mm);
  EXPECT_EQ(record->header.refractive_index, kHeader.refractive_index);
  EXPECT_EQ(record->header.numerical_aperture, kHeader.numerical_aperture);
  EXPECT_EQ(record->torn_bytes, 0u);
  ASSERT_EQ(record->cracks.size(), 5000u);
  for (std::uint64_t tick = 1; tick <= 5000; ++tick)
    ExpectSame(record->cracks[tick - 1], Crack(tick));
}

TEST(Glass, RefusesNothing) {
  const fs::path file = RecordOfThisTest();
  auto glass = Glass::Create(file, kHeader);
  ASSERT_TRUE(glass.has_value());
  const std::vector<formats::GlassCrack> cracks = {
      Crack(7),                                    // the first
      Crack(7),                                    // the same place again
      {3, Vec3(-500, 1e9, -1e-300), 0, 3, false},  // earlier, far beside, no energy
      {std::numeric_limits<std::uint64_t>::max(), Vec3::Zero(), 1e30, 0, true},
  };
  for (const auto& crack : cracks) glass->Add(crack);
  ASSERT_TRUE(glass->Flush().has_value());
  const auto record = formats::ReadGlassRecord(file);
  ASSERT_TRUE(record.has_value());
  ASSERT_EQ(record->cracks.size(), cracks.size());
  for (std::size_t i = 0; i < cracks.size(); ++i)
    ExpectSame(record->cracks[i], cracks[i]);
}

TEST(Glass, BeginsTheRecordAnew) {
  const fs::path file = RecordOfThisTest();
  {
    auto old = Glass::Create(file, kHeader);
    ASSERT_TRUE(old.has_value());
    old->Add(Crack(1));
    ASSERT_TRUE(old->Flush().has_value());
  }
  ASSERT_TRUE(Glass::Create(file, kHeader).has_value());
  EXPECT_TRUE(formats::ReadGlassRecord(file)->cracks.empty());
}

TEST(Glass, ReportsWhereItCannotWrite) {
  const auto glass = Glass::Create(RecordOfThisTest() / "not" / "here", kHeader);
  ASSERT_FALSE(glass.has_value());
  EXPECT_EQ(glass.error().code, ErrorCode::kIo);
  EXPECT_NE(glass.error().message.find("not/here"), std::string::npos);
}

/// No file of this process may grow beyond `bytes`, as on a full disk; until it goes.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, SIG_DFL);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
};

TEST(Glass, WhatAFullDiskRefusedIsWrittenLater) {
  const fs::path file = RecordOfThisTest();
  auto glass = Glass::Create(file, kHeader);
  ASSERT_TRUE(glass.has_value());
  for (std::uint64_t tick = 1; tick <= 10; ++tick) glass->Add(Crack(tick));
  ASSERT_TRUE(glass->Flush().has_value());
  {
    // Room for one record and a half, out of 2000.
    const FullDisk full(fs::file_size(file) + formats::kGlassRecordSize * 3 / 2);
    for (std::uint64_t tick = 11; tick <= 2010; ++tick) glass->Add(Crack(tick));
    for (int attempt = 0; attempt < 3; ++attempt) {
      const auto flushed = glass->Flush();
      ASSERT_FALSE(flushed.has_value());
      EXPECT_EQ(flushed.error().code, ErrorCode::kIo);
      EXPECT_GE(formats::ReadGlassRecord(file)->cracks.size(), 10u);
    }
  }
  ASSERT_TRUE(glass->Flush().has_value());
  const auto record = formats::ReadGlassRecord(file);
  ASSERT_TRUE(record.has_value());
  EXPECT_EQ(record->torn_bytes, 0u);
  ASSERT_EQ(record->cracks.size(), 2010u);
  for (std::uint64_t tick = 1; tick <= 2010; ++tick)
    ExpectSame(record->cracks[tick - 1], Crack(tick));
}

}  // namespace
}  // namespace intaglio::virtual_engraver
