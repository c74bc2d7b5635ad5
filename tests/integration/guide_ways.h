#pragma once

// What the guide laser of a virtual BJJCZ board has drawn, by the board's own record
// (virtual_bjjcz_main.cc).

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "engrave/core/geometry.h"
#include "tests/integration/run_program.h"

namespace intaglio::testing {

struct GuideWay {
  Vec2 from_mm = Vec2::Zero(), to_mm = Vec2::Zero();
};

/// Each with the gate of the laser closed.
inline std::vector<GuideWay> GuideWaysOf(const std::filesystem::path& record_file,
                                         double field_mm) {
  std::vector<GuideWay> ways;
  std::ifstream record(record_file);
  for (std::string line; std::getline(record, line);) {
    std::istringstream in(line);
    std::string kind, gate;
    Vec2 from, to;
    if (!(in >> kind >> from.x() >> from.y() >> to.x() >> to.y()) || kind != "guide")
      continue;
    EXPECT_FALSE(in >> gate) << "the gate is open: " << line;
    const Vec2 middle = Vec2::Constant(32768);
    ways.push_back(
        {field_mm / 65536 * (from - middle), field_mm / 65536 * (to - middle)});
  }
  return ways;
}

/// A client that draws: `start` begins one, `count` is of the ways drawn so far. On a
/// computer that is too busy for 200 ms the machine lets go; the person then gives the
/// command again.
inline std::unique_ptr<Running> AwaitDrawing(
    const std::function<std::unique_ptr<Running>()>& start,
    const std::function<std::size_t()>& count) {
  using std::chrono::seconds;
  std::unique_ptr<Running> client;
  EXPECT_TRUE(Eventually(
      [&] {
        if (!client || !client->running()) {
          EXPECT_TRUE(!client || client->WaitForEnd(seconds(1)).exit_code != 2)
              << client->Output();
          client = start();
        }
        const std::size_t before = count();
        return Eventually([&] { return count() > before + 20; }, seconds(20));
      },
      seconds(90)))
      << client->Output();
  return client;
}

/// Nothing is drawn any more: nothing within a second, at last.
inline bool GuideRests(const std::function<std::size_t()>& count) {
  return Eventually(
      [&] {
        const std::size_t before = count();
        std::this_thread::sleep_for(std::chrono::seconds(1));
        return count() == before;
      },
      std::chrono::seconds(30));
}

/// What ends an outline that is drawn.
struct OutlineEnding {
  std::string name;
  std::function<void(Running&)> inflict, relieve;
  std::string answer = {};    ///< what the client prints, if it lives
  bool begins_a_job = false;  ///< the laser may fire behind it
};

/// Each ends one of `drawing`, and none begins again by itself; `rests`: GuideRests;
/// `has_fired`: the laser has made something.
inline void ExpectEachEndsIt(const std::vector<OutlineEnding>& endings,
                             const std::function<std::unique_ptr<Running>()>& drawing,
                             const std::function<bool()>& rests,
                             const std::function<bool()>& has_fired) {
  for (const OutlineEnding& ending : endings) {
    const auto client = drawing();
    std::cout << "  " << ending.name << std::endl;
    ending.inflict(*client);
    EXPECT_TRUE(rests()) << ending.name;
    if (!ending.answer.empty()) {
      const Ended ended = client->WaitForEnd(std::chrono::seconds(20));
      EXPECT_EQ(ended.exit_code, 4) << ending.name << ": " << ended.output;
      EXPECT_THAT(ended.output, ::testing::HasSubstr(ending.answer)) << ending.name;
    }
    ending.relieve(*client);
    EXPECT_TRUE(rests()) << ending.name << ": it begins again by itself";
    if (!ending.begins_a_job) {
      EXPECT_FALSE(has_fired()) << ending.name;
    }
  }
}

}  // namespace intaglio::testing
