#pragma once

// Clients of the real job service, whose workers are played by the test.

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "services/client/job_client.h"
#include "tests/services/job_service/fake_shop.h"
#include "tests/test_folder.h"

namespace intaglio::client {

/// A discretizer, a sorter and a synchronizer that are quick. The lamp warms up until the
/// test lets it fire.
class PlayedShop {
 public:
  PlayedShop() : playing_([this](const std::stop_token& stop) { Play(stop); }) {}
  std::atomic<bool> ready = false;  ///< the workers are there
  std::atomic<bool> warm = false;   ///< what is permitted is fired
  std::atomic<bool> slow = false;   ///< it begins with what is permitted, and goes on

 private:
  void Play(const std::stop_token& stop) {
    job_service::FakeShop shop(test::PrivateBusOptions());
    std::string done;
    while (!stop.stop_requested()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      shop.Poll();
      if (!ready) continue;
      const job_service::TaskCopy task = shop.Task(intaglio_STAGE_ENGRAVE);
      const bool at_work = !task.job_uid.empty() && !task.revoked && task.job_uid != done;
      const auto health = at_work ? intaglio_HEALTH_BUSY : intaglio_HEALTH_READY;
      shop.Health(intaglio_STAGE_DISCRETIZE, "d", health);
      shop.Health(intaglio_STAGE_SORT, "s", health);
      shop.Health(intaglio_STAGE_ENGRAVE, "y", health);
      if (!at_work) continue;
      for (const auto stage : {intaglio_STAGE_DISCRETIZE, intaglio_STAGE_SORT}) {
        if (shop.Task(stage).job_uid == task.job_uid) {
          shop.Report(shop.Task(stage), stage, intaglio_TASK_DONE, 100, 100);
        }
      }
      const bool fires = warm && shop.granted();
      if (fires) done = task.job_uid;
      shop.Report(task, intaglio_STAGE_ENGRAVE,
                  fires ? intaglio_TASK_DONE : intaglio_TASK_RUNNING,
                  fires ? 100 : (slow && shop.granted() ? 1 : 0), 100);
    }
  }
  std::jthread playing_;
};

class JobClientTest : public ::testing::Test {
 protected:
  JobClientTest() : folder_(test::FreshFolder()) {}
  void Start() { service_.emplace(folder_, test::PrivateTag()); }
  /// Bob sees what ann submitted.
  JobView OfBob(const std::string& uid) {
    EXPECT_TRUE(bob_.PollUntil([&] { return bob_.jobs().contains(uid); },
                               std::chrono::seconds(10)));
    return bob_.jobs().at(uid);
  }
  JobView BobAwaits(const std::string& uid,
                    const std::function<bool(const JobView&)>& condition) {
    EXPECT_TRUE(bob_.PollUntil([&] { return condition(bob_.jobs().at(uid)); },
                               std::chrono::seconds(10)));
    return bob_.jobs().at(uid);
  }

  std::filesystem::path folder_;
  bus::Bus bus_{test::PrivateBusOptions()};
  JobClient ann_{bus_}, bob_{bus_};
  PlayedShop shop_;
  std::optional<job_service::ServiceProcess> service_;
};

}  // namespace intaglio::client
