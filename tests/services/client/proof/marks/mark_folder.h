#pragma once

// A job of marks in a folder made by hand: four circles of 1 mm on a piece, or on a web a
// repeat each, burnt as planned. Tests put faults into it.

#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <vector>

#include "engrave/formats/journal_file.h"
#include "engrave/formats/mark_record.h"
#include "engrave/mark/mark_file.h"
#include "proto/task.pb.h"
#include "services/platform/link/scan_head_protocol.h"
#include "tests/test_folder.h"

namespace intaglio::client::testing {

inline constexpr double kRadiusMm = 0.5, kToleranceUm = 20, kWebPitchMm = 30;
inline constexpr double kEnergyMjMm = 2;
inline constexpr std::uint32_t kHeadPowerUp = 0xbeef, kRun = 3;
inline constexpr const char* kSerialNumber = "head-7";

/// Burnt in chords of 5 um from the angle 0 on, `turns` around.
struct BurntCircle {
  Vec2 off_mm = Vec2::Zero();  ///< its centre, from where it is planned
  double radius_mm = kRadiusMm, turns = 1, energy_mj_mm = kEnergyMjMm;
  std::uint32_t run = kRun;
};

class MarkFolder {
 public:
  explicit MarkFolder(bool on_web) : on_web_(on_web), folder_(test::FreshFolder()) {
    marks_.pens = {{"item 1", 200, 0.5, 20000, 1, 0, 0}, {"item 2", 100, 1, 0, 1, 0, 0}};
    for (std::uint32_t i = 0; i < 4; ++i) {
      mark::Mark mark;
      mark.pen = i == 3 ? 1 : 0;
      mark.closed = true;
      mark.web_mm = on_web ? kWebPitchMm * i : 0;
      const Vec2 centre_mm(on_web ? 1 : 3.0 * i, 2);
      mark.places = {{centre_mm + Vec2(kRadiusMm, 0), 1},
                     {centre_mm - Vec2(kRadiusMm, 0), 1}};
      marks_.marks.push_back(mark);
      burnt_.push_back({BurntCircle()});
      journal_.push_back(formats::PointOutcome::kMade);
    }
    frozen_.set_job_uid("1-abc");
    frozen_.mutable_job()->set_name("four circles");
    frozen_.mutable_job()->mutable_marks()->add_items();
    MachineSpec& machine = *frozen_.mutable_machine();
    machine.set_name("galvo");
    machine.mutable_scan_head()->set_field_mm(100);
    machine.mutable_scan_head()->set_jump_mm_s(5000);
    machine.mutable_scan_head()->set_tolerance_um(kToleranceUm);
    machine.mutable_mark_line()->set_protocol("scan-head");
    machine.mutable_mark_line()->set_serial_number(kSerialNumber);
    if (on_web) {
      frozen_.mutable_job()->mutable_marks()->mutable_web();
      frozen_.mutable_job()->mutable_marks()->mutable_repeats()->set_pitch_mm(
          kWebPitchMm);
    }
  }

  const std::filesystem::path& folder() const { return folder_; }

  /// Job, marks and journal as the marker leaves them.
  void WriteJob() const {
    std::string json;
    ASSERT_TRUE(google::protobuf::util::MessageToJsonString(frozen_, &json).ok());
    std::ofstream(folder_ / "job.json") << json;
    ASSERT_TRUE(mark::WriteMarkFile(folder_ / "marks.bin", marks_));
    WriteJournal();
  }
  /// And what was burnt.
  void Write() const {
    WriteJob();
    ASSERT_TRUE(formats::WriteMarkRecord(folder_ / "burnt.rec", Record()));
  }
  formats::MarkRecord Record() const {
    formats::MarkRecord record{{100, kHeadPowerUp}, {}, 0};
    for (std::uint32_t i = 0; i < burnt_.size(); ++i)
      for (const BurntCircle& circle : burnt_[i]) Burn(i, circle, record.ticks);
    for (std::uint32_t i = 0; i < stray_ticks_; ++i)
      record.ticks.push_back(
          {NextTick(record.ticks), {9, 9}, {0.002, 0}, 0.004, kRun, 0xffffffff});
    return record;
  }

  bool on_web_ = false;
  std::filesystem::path folder_;
  FrozenJob frozen_;
  mark::MarkSet marks_;
  std::vector<std::vector<BurntCircle>> burnt_;  ///< of each mark
  /// What became of each mark; kNone: never begun; kUncertain: an intent and that.
  std::vector<formats::PointOutcome> journal_;
  std::uint32_t stray_ticks_ = 0;

 private:
  static std::uint64_t NextTick(const std::vector<formats::BurntTick>& ticks) {
    return ticks.empty() ? 1000 : ticks.back().tick + 1;
  }
  void Burn(std::uint32_t mark, const BurntCircle& circle,
            std::vector<formats::BurntTick>& ticks) const {
    const mark::Mark& planned = marks_.marks[mark];
    const Vec2 centre_mm = (planned.places[0].at_mm + planned.places[1].at_mm) / 2 -
                           Vec2(planned.web_mm, 0) + circle.off_mm;
    const double all_rad = 2 * std::numbers::pi * circle.turns;
    const int count = static_cast<int>(all_rad * circle.radius_mm / 0.005);
    const auto at = [&](int i) {
      const double rad = all_rad * i / count;
      return Vec2(centre_mm + circle.radius_mm * Vec2(std::cos(rad), std::sin(rad)));
    };
    // 10 ms of the way to it.
    const std::uint64_t first = NextTick(ticks) + (ticks.empty() ? 0 : 1000);
    for (int i = 1; i <= count; ++i) {
      const Vec2 way_mm = at(i) - at(i - 1);
      ticks.push_back({first + static_cast<std::uint64_t>(i), at(i), way_mm,
                       circle.energy_mj_mm * way_mm.norm(), circle.run, mark});
    }
  }
  void WriteJournal() const {
    using formats::JournalKind, formats::PointOutcome;
    std::ofstream out(folder_ / "journal.bin", std::ios::binary);
    const auto put = [&](const auto& bytes) {
      out.write(reinterpret_cast<const char*>(bytes.data()),
                static_cast<std::streamsize>(bytes.size()));
    };
    put(formats::EncodeJournalHeader({marks_.marks.size(), 1, mark::MarksCrc(marks_)}));
    formats::JournalRecord session;
    session.kind = JournalKind::kSession;
    session.run = kRun;
    session.point =
        formats::PowerUpOfText(link::HeadPowerUpText(kSerialNumber, kHeadPowerUp));
    put(formats::EncodeJournalRecord(session));
    for (std::uint32_t i = 0; i < journal_.size(); ++i) {
      if (journal_[i] == PointOutcome::kNone) continue;
      formats::JournalRecord record;
      record.run = kRun;
      record.tick = kRun;
      record.point = i;
      put(formats::EncodeJournalRecord(record));
      record.kind = JournalKind::kOutcome;
      record.outcome = journal_[i];
      put(formats::EncodeJournalRecord(record));
    }
  }
};

}  // namespace intaglio::client::testing
