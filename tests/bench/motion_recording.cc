// What an hour of motion takes on the disk: 1000 MotionState samples a second of machine
// time, of a stage that makes points 1.2 mm apart without stopping, through the
// recorder's own files.
//
//   motion_recording [SECONDS [NOISE_UM [LEVEL]]]
// default an hour, no noise of encoders, and the recorder's own level of compression

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "engrave/drive/first_order.h"
#include "engrave/motion/planner.h"
#include "services/recorder/recording_series.h"
#include "tests/engrave/motion/hermite_velocity.h"

namespace {

using namespace intaglio;
namespace fs = std::filesystem;

constexpr double kLampHz = 200;
constexpr std::uint64_t kSampleNs = 1'000'000;

/// Plain CDR, little endian, as MotionState of idl/motion.idl is on the bus.
class Cdr {
 public:
  Cdr() : bytes_{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}} {}
  template <typename T>
  void Put(T value) {
    while ((bytes_.size() - 4) % sizeof value != 0) bytes_.push_back(std::byte{0});
    const auto at = bytes_.size();
    bytes_.resize(at + sizeof value);
    std::memcpy(bytes_.data() + at, &value, sizeof value);
  }
  void Put(const std::string& text) {
    Put(static_cast<std::uint32_t>(text.size() + 1));
    for (const char c : text) bytes_.push_back(static_cast<std::byte>(c));
    bytes_.push_back(std::byte{0});
  }
  const recording::Bytes& bytes() const { return bytes_; }

 private:
  recording::Bytes bytes_;
};

/// As the motion bridge rounds them.
double Rounded(double value, int bits) {
  return std::ldexp(std::nearbyint(std::ldexp(value, bits)), -bits);
}

recording::Bytes SampleOf(std::uint64_t tick, std::uint64_t covered, const Vec3& at_mm,
                          const Vec3& mm_s, double error_um) {
  Cdr cdr;
  cdr.Put(std::string("els-03"));
  cdr.Put(tick);
  for (int axis = 0; axis < 3; ++axis) cdr.Put(Rounded(at_mm[axis], 20));
  for (int axis = 0; axis < 3; ++axis) cdr.Put(Rounded(mm_s[axis], 10));
  cdr.Put(std::uint32_t{1});  // run
  cdr.Put(std::uint32_t{1});  // highest_run
  cdr.Put(covered);
  cdr.Put(std::uint8_t{0});  // at_rest
  cdr.Put(error_um);
  cdr.Put(std::uint32_t{0});  // fault
  cdr.Put(std::string());
  cdr.Put(std::uint32_t{0});  // clock
  return cdr.bytes();
}

/// A walk through a block of 100 mm, planned as it goes.
class Walk {
 public:
  Walk() : planner_(motion::MakePlanner(Options(), at_)) {}
  /// The state that many seconds after the start; time only grows.
  motion::KnotState At(double seconds) {
    while (seconds >= begun_s_ + DurationOfFront()) {
      from_ = segments_[next_].end();
      begun_s_ += DurationOfFront();
      ++next_;
    }
    const double since_s = seconds - begun_s_, duration_s = DurationOfFront();
    return {motion::HermitePosition(from_, segments_[next_], since_s, duration_s),
            motion::HermiteVelocity(from_, segments_[next_], since_s, duration_s)};
  }

 private:
  static motion::PlanOptions Options() {
    motion::PlanOptions options;
    options.limits.max_speed_mm_s = Vec3::Constant(80);
    options.limits.max_acceleration_mm_s2 = Vec3::Constant(7000);
    options.rate_hz = kLampHz;
    options.continuous = true;
    options.drive = std::make_shared<drive::FirstOrder>(0.0002);
    return options;
  }
  double DurationOfFront() {
    while (next_ >= segments_.size()) {
      segments_.clear();
      next_ = 0;
      Vec3 step(normal_(random_), normal_(random_), normal_(random_));
      at_ += 1.2 * step.normalized();
      at_ = at_.cwiseMax(0.0).cwiseMin(100.0);
      planner_->Append(at_, ++point_, true, segments_);
    }
    return motion::DurationSeconds(segments_[next_].duration_subticks, kLampHz);
  }

  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;
  Vec3 at_ = Vec3::Constant(50);
  std::unique_ptr<motion::Planner> planner_;
  std::vector<motion::Segment> segments_;
  std::size_t next_ = 0;
  motion::KnotState from_{at_, Vec3::Zero()};
  double begun_s_ = 0;
  std::int32_t point_ = -1;
};

}  // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 3600;
  const double noise_mm = argc > 2 ? 1e-3 * std::atof(argv[2]) : 0;
  const fs::path folder =
      fs::temp_directory_path() / fmt::format("motion_recording-{}", getpid());
  fs::create_directories(folder);
  recorder::SeriesOptions options;
  options.file = folder / "motion.mcap";
  options.writer.chunk_ns = 500'000'000;  // as the recorder has it
  if (argc > 3) options.writer.compression_level = std::atoi(argv[3]);
  auto series = recorder::RecordingSeries::Open(options, 0);
  if (!series) {
    fmt::print(stderr, "{}\n", series.error().message);
    return 1;
  }
  const auto stream = series->AddStream({"MotionState",
                                         "intaglio::MotionState",
                                         false,
                                         "els-03",
                                         recording::SampleKind::kValue,
                                         true,
                                         {}},
                                        {});
  Walk walk;
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, 1);
  const auto begin = std::chrono::steady_clock::now();
  const auto count = static_cast<std::uint64_t>(seconds * 1000);
  std::uint64_t raw_bytes = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const double at_s = static_cast<double>(i) * 1e-3;
    motion::KnotState state = walk.At(at_s);
    for (int axis = 0; axis < 3; ++axis)
      state.position_mm[axis] += noise_mm * noise(random);
    const auto tick = static_cast<std::uint64_t>(at_s * kLampHz);
    const auto payload = SampleOf(tick, tick + 200 - tick % 50, state.position_mm,
                                  state.velocity_mm_s, 16.1);
    raw_bytes += payload.size();
    series->Write(stream, (i + 1) * kSampleNs, (i + 1) * kSampleNs - kSampleNs / 20,
                  payload);
    if (i % 100 == 99) series->Turn((i + 1) * kSampleNs);
  }
  const bool closed = series->Close().has_value();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  fmt::print(
      "{} samples, {:.0f} s of machine time in {:.1f} s: {:.1f} MB of samples, {:.1f} "
      "MB on disk, {} missing\n",
      count, seconds, took.count(), static_cast<double>(raw_bytes) / 1e6,
      static_cast<double>(fs::file_size(options.file)) / 1e6, series->missing_count());
  fs::remove_all(folder);
  return closed && series->missing_count() == 0 ? 0 : 1;
}
