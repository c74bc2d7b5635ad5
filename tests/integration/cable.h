#pragma once

// Two hosts and the cable between them, for tests: each host is a network namespace with
// loopback and one interface, "eth0"; what leaves it comes out of a TAP device, which the
// test holds and from which it carries every frame to the other one, or does not.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <random>
#include <string>
#include <thread>

namespace intaglio::testing {

/// Programs that are started during a Visit live on this host.
class TestHost {
 public:
  /// `address`: e.g. "10.77.0.1". Throws std::runtime_error where it cannot be.
  explicit TestHost(const char* address);
  ~TestHost();
  TestHost(const TestHost&) = delete;
  TestHost& operator=(const TestHost&) = delete;

  /// The calling thread is on this host until the result goes.
  class Visit {
   public:
    explicit Visit(const TestHost& host);
    ~Visit();
    Visit(const Visit&) = delete;
    Visit& operator=(const Visit&) = delete;

   private:
    int home_ = -1;
  };
  int tap() const { return tap_; }

 private:
  int network_ = -1;  // descriptor of the namespace
  int tap_ = -1;
};

/// Why there can be no TestHost here; empty when there can.
std::string WhyNoHosts();

/// Carries frames both ways in a thread of its own.
class Cable {
 public:
  Cable(const TestHost& a, const TestHost& b, std::uint32_t seed);
  ~Cable();
  Cable(const Cable&) = delete;
  Cable& operator=(const Cable&) = delete;

  void Cut(bool a_to_b, bool b_to_a);
  void Restore() { Cut(false, false); }
  /// Loses this share of each way's frames, at random; 0..1.
  void Lose(double ratio) { loss_ = ratio; }
  std::uint64_t carried() const { return carried_; }
  std::uint64_t lost() const { return lost_; }

 private:
  void Carry(const std::stop_token& stop);
  bool Falls(bool from_a);

  int taps_[2];
  std::mt19937 random_;
  std::atomic<bool> cut_[2] = {false, false};  // from a, from b
  std::atomic<double> loss_ = 0;
  std::atomic<std::uint64_t> carried_ = 0, lost_ = 0;
  std::jthread thread_;
};

}  // namespace intaglio::testing
