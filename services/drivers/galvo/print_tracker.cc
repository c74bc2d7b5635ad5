#include "services/drivers/galvo/print_tracker.h"

#include <fmt/format.h>

#include <algorithm>

#include "engrave/core/check.h"
#include "engrave/core/counted.h"

namespace intaglio::drivers {
namespace {

constexpr std::size_t kMaxRecent = 256;
// A print that is found needs two print marks behind those that may be missing.
constexpr double kPitchesToFind = 3;

}  // namespace

void PrintTracker::Forget() { *this = PrintTracker(); }

void PrintTracker::Begin(const PrintEye& eye) {
  eye_ = eye;
  begin_mm_ = now_mm_;
  found_ = lost_ = false;
  missing_in_a_row_ = 0;
  places_mm_.clear();
  ignored_ = 0;
}

bool PrintTracker::LiesAPitchBehindAnother(double place_mm) const {
  return std::ranges::any_of(recent_mm_, [&](double before_mm) {
    return std::abs(place_mm - before_mm - eye_.pitch_mm) <= eye_.tolerance_mm;
  });
}

void PrintTracker::Receive(double place_mm) {
  found_ = true;
  last_mm_ = place_mm;
  missing_in_a_row_ = 0;
  places_mm_.push_back(place_mm);
}

void PrintTracker::See(double place_mm, bool in_run) {
  PassTo(place_mm);
  if (!lost_ && !found_ && in_run) {
    if (LiesAPitchBehindAnother(place_mm)) Receive(place_mm);
  } else if (!lost_ && in_run) {
    if (std::abs(place_mm - ExpectedMm()) <= eye_.tolerance_mm) {
      Receive(place_mm);
    } else {
      ++ignored_;
    }
  }
  recent_mm_.push_back(place_mm);
  if (recent_mm_.size() > kMaxRecent) recent_mm_.pop_front();
}

void PrintTracker::PassTo(double place_mm) {
  now_mm_ = std::max(now_mm_, place_mm);
  if (lost_) return;
  if (!found_) {
    lost_ = now_mm_ - begin_mm_ > (eye_.max_missing + kPitchesToFind) * eye_.pitch_mm;
    return;
  }
  while (!lost_ && now_mm_ > ExpectedMm() + eye_.tolerance_mm) {
    ++missing_in_a_row_;
    lost_ = missing_in_a_row_ > eye_.max_missing;
    if (!lost_) places_mm_.push_back(std::nullopt);
  }
}

PrintTracker::State PrintTracker::StateOf(std::uint32_t repeat) const {
  Require(repeat >= eye_.first_repeat, "repeat {} is before the run's first, {}", repeat,
          eye_.first_repeat);
  const std::size_t at = repeat - eye_.first_repeat;
  if (at >= places_mm_.size()) return lost_ ? State::kLost : State::kAwaited;
  return places_mm_[at] ? State::kSeen : State::kMissing;
}

double PrintTracker::PlaceOf(std::uint32_t repeat) const {
  return places_mm_.at(repeat - eye_.first_repeat).value();
}

std::string PrintTracker::LossText() const {
  const char* const remedy =
      "check the photo eye, the print and marks.repeats.pitch_mm, then resume";
  if (!found_) {
    return fmt::format(
        "the photo eye has seen no print mark {:g} mm behind another one (within {:g} "
        "mm) in {:.0f} mm of web: {}",
        eye_.pitch_mm, eye_.tolerance_mm, now_mm_ - begin_mm_, remedy);
  }
  return fmt::format(
      "{} missing in a row, and marks.web.eye.max_missing is {}; the last one was that "
      "of repeat {}: {}",
      Counted(missing_in_a_row_, "print mark"), eye_.max_missing,
      eye_.first_repeat + places_mm_.size() - (missing_in_a_row_ - 1), remedy);
}

}  // namespace intaglio::drivers
