#pragma once

// Waiting with an end, on hosts that are noisy: a virtual computer may be given a quarter
// of its processors' time only, other tests run beside this one, and a bound is meant for
// what the tested code needs.

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <string>
#include <thread>

namespace intaglio::test {

/// Jiffies of all processors so far: those they worked, and those that the host of this
/// computer gave to others; and the seconds in which something that could have run waited
/// for a processor (the kernel's pressure stall information). Zeros where the system does
/// not report them.
struct HostTime {
  double all = 0, worked = 0, stolen = 0, contended_s = 0;

  static HostTime Now() {
    enum Field { kIdle = 3, kWaiting = 4, kStolen = 7, kFields = 8 };
    std::ifstream in("/proc/stat");
    std::string name;
    in >> name;
    HostTime time;
    double jiffies = 0;
    for (int field = 0; field < kFields && in >> jiffies; ++field) {
      time.all += jiffies;
      if (field == kStolen) {
        time.stolen = jiffies;
      } else if (field != kIdle && field != kWaiting) {
        time.worked += jiffies;
      }
    }
    time.contended_s = ContendedSeconds();
    return time;
  }
  double StolenPercentSince(const HostTime& before) const {
    return 100 * (stolen - before.stolen) / std::max(1.0, all - before.all);
  }

 private:
  /// The first line of the file is "some avg10=… avg60=… avg300=… total=MICROSECONDS".
  static double ContendedSeconds() {
    std::ifstream in("/proc/pressure/cpu");
    const std::string name = "total=";
    for (std::string word; in >> word;) {
      if (word.starts_with(name)) return 1e-6 * std::stod(word.substr(name.size()));
    }
    return 0;
  }
};

/// A bound in time that was given: what others took does not count, for up to kMaxTimes
/// the bound. That is the share of the host of this computer; and for a bound of
/// kEndsAHang or longer, which no test means as the time that something takes, also the
/// time in which something waited for a processor.
class Patience {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr double kMaxTimes = 4;
  static constexpr Clock::duration kEndsAHang = std::chrono::seconds(10);

  explicit Patience(Clock::duration bound)
      : bound_(bound), began_(Clock::now()), before_(HostTime::Now()) {}

  bool over() const {
    const auto waited = Clock::now() - began_;
    if (waited < bound_) return false;
    if (waited > bound_ * kMaxTimes) return true;
    const HostTime now = HostTime::Now();
    const double worked = now.worked - before_.worked;
    const double stolen = now.stolen - before_.stolen;
    std::chrono::duration<double> alone = waited;
    if (bound_ >= kEndsAHang) {
      alone -= std::chrono::duration<double>(now.contended_s - before_.contended_s);
    }
    if (worked + stolen > 0) alone *= worked / (worked + stolen);
    return alone > bound_;
  }

 private:
  Clock::duration bound_;
  Clock::time_point began_;
  HostTime before_;
};

/// Checks until the condition holds or the patience is over; the last check counts.
/// Discovery between processes has no event of its own that could be waited for.
///
/// The pause before the next check is 2 ms, or four times what the check took, 300 ms at
/// most. A check that runs a program of the bus costs a fifth of a processor when it
/// never pauses: 35 ms for itself, and what every other participant does about it.
inline bool Eventually(const std::function<bool()>& condition,
                       std::chrono::milliseconds bound = std::chrono::seconds(10)) {
  constexpr Patience::Clock::duration kShortest = std::chrono::milliseconds(2),
                                      kLongest = std::chrono::milliseconds(300);
  const Patience patience(bound);
  while (!patience.over()) {
    const auto began = Patience::Clock::now();
    if (condition()) return true;
    const auto took = Patience::Clock::now() - began;
    std::this_thread::sleep_for(std::clamp(4 * took, kShortest, kLongest));
  }
  return condition();
}

}  // namespace intaglio::test
