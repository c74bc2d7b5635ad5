#pragma once

// A shop with a virtual engraver, whose machine is moved by hand and taught by commands.

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cmath>
#include <memory>
#include <regex>

#include "engrave/formats/glass_record.h"
#include "proto/teach.pb.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio::testing {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class TeachShop : public ::testing::Test {
 protected:
  /// Its lamp warms up for so long, s, at five times the speed.
  explicit TeachShop(int warm_up_s = 2) {
    up_ = std::make_unique<Running>(
        Program("intaglio"),
        With({"up", "--folder", shop().string(), "--materials",
              (folder_ / "materials.db").string(), "--speed", "5", "--warm-up",
              std::to_string(warm_up_s), "--block", "50", "50", "30"}),
        folder_ / "up.txt");
  }
  ~TeachShop() override {
    up_->Signal(SIGINT);
    up_->WaitForEnd(20s);
  }
  void SetUp() override {
    ASSERT_TRUE(Eventually(
        [this] { return up_->Output().find("the shop is open") != std::string::npos; },
        60s))
        << up_->Output();
  }

  fs::path shop() const { return folder_ / "shop"; }
  std::vector<std::string> With(std::vector<std::string> words) const {
    words.insert(words.end(),
                 {"--domain", "49", "--tag", "teach" + std::to_string(getpid())});
    return words;
  }
  Ended Type(const std::vector<std::string>& words) {
    Running run(Program("intaglio"), With(words), folder_ / "typed.txt");
    return run.WaitForEnd(60s);
  }
  Ended Teach(std::vector<std::string> words) {
    words.insert(words.begin(), "teach");
    return Type(words);
  }
  /// The machine let go, or its laser was not heard, for lack of processor time.
  static bool EndsByABusyComputer(const Ended& ended) {
    return ended.output.find("let go") != std::string::npos ||
           ended.output.find("door are not known") != std::string::npos;
  }
  /// A command of `teach` that has to succeed. On a computer that is too busy for 200 ms
  /// the machine lets go, for 150 ms key and door are not known; the operator then gives
  /// the command again.
  std::string Do(const std::vector<std::string>& words) {
    Ended ended;
    for (int i = 0; i < 10; ++i) {
      ended = Teach(words);
      if (!EndsByABusyComputer(ended)) break;
    }
    EXPECT_EQ(ended.exit_code, 0) << ended.output;
    return ended.output;
  }
  static std::string NumberIn(const std::string& output) {
    std::smatch number;
    EXPECT_TRUE(std::regex_search(output, number, std::regex("job ([0-9]+)"))) << output;
    return number[1];
  }
  /// The number of a small job with the shop's profile, which has what was taught.
  std::string Submit(const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {
        "submit",    std::string(INTAGLIO_SOURCE_DIR) + "/deploy/jobs/sample.textproto",
        "--machine", (shop() / "machine.textproto").string(),
        "--height",  "4",
        "--spacing", "0.5"};
    words.insert(words.end(), more.begin(), more.end());
    return NumberIn(Type(words).output);
  }
  /// A machine in real time may pause by itself when this host is too busy for its lines;
  /// the operator then does what the message asks for.
  bool RunsTo(const std::string& job, const std::string& state) {
    return Eventually(
        [&] {
          shown_ = Type({"show", job}).output;
          if (shown_.find("state      " + state) != std::string::npos) return true;
          if (shown_.find("state      paused") != std::string::npos)
            Type({"resume", job});
          return false;
        },
        90s);
  }
  std::vector<formats::GlassCrack> Cracks() const {
    const auto glass = formats::ReadGlassRecord(shop() / "glass.rec");
    return glass ? glass->cracks : std::vector<formats::GlassCrack>{};
  }
  TeachStatus StatusNow() {
    const std::string text = Teach({"status", "--json"}).output;
    TeachStatus status;
    EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(
                    text.substr(std::min(text.size(), text.find('{'))), &status)
                    .ok())
        << text;
    return status;
  }
  bool IsAt(const Vec3& place) {
    const TeachStatus status = StatusNow();
    if (status.axes_size() != 3) return false;
    for (int i = 0; i < 3; ++i) {
      if (std::abs(status.axes(i).position() - place[i]) > 0.002) return false;
    }
    return true;
  }
  std::string Logs() const {
    std::string text;
    for (const auto& entry : fs::recursive_directory_iterator(shop())) {
      if (entry.path().extension() == ".log") text += testing::TextIn(entry.path());
    }
    return text;
  }

  fs::path folder_ = test::FreshFolder();
  std::unique_ptr<Running> up_;
  std::string shown_;
};

}  // namespace intaglio::testing
