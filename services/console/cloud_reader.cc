#include "services/console/cloud_reader.h"

#include <system_error>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "services/console/job_cloud.h"

namespace intaglio::console {
namespace {

constexpr std::size_t kMaxWaiting = 32;
constexpr std::uint64_t kMaxResultBytes = 64 << 20;

}  // namespace

CloudReader::CloudReader()
    : thread_([this](const std::stop_token& stop) { Run(stop); }) {}

CloudReader::~CloudReader() {
  thread_.request_stop();
  thread_.join();
}

bool CloudReader::AskForPlan(std::filesystem::path folder, Answer answer) {
  return Ask([this, folder = std::move(folder), answer = std::move(answer)] {
    answer(Plan(folder));
  });
}

bool CloudReader::AskForMade(std::filesystem::path folder, std::uint32_t from,
                             Answer answer) {
  return Ask([folder = std::move(folder), from, answer = std::move(answer)] {
    auto made = ReadMade(folder, from);
    if (!made) return answer(tl::unexpected(made.error()));
    answer(std::make_shared<const std::string>(std::move(*made)));
  });
}

bool CloudReader::AskForFile(std::filesystem::path file, Answer answer) {
  return Ask([file = std::move(file), answer = std::move(answer)] {
    auto bytes = io::ReadWholeFile(file, kMaxResultBytes);
    if (!bytes) return answer(tl::unexpected(bytes.error()));
    answer(std::make_shared<const std::string>(std::move(*bytes)));
  });
}

bool CloudReader::Ask(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    if (work_.size() >= kMaxWaiting) return false;
    work_.push_back(std::move(work));
  }
  changed_.notify_one();
  return true;
}

void CloudReader::Run(const std::stop_token& stop) {
  for (;;) {
    std::function<void()> work;
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [this] { return !work_.empty(); })) return;
      work = std::move(work_.front());
      work_.pop_front();
    }
    work();
  }
}

Result<CloudReader::Bytes> CloudReader::Plan(const std::filesystem::path& folder) {
  std::error_code error;
  const auto written = std::filesystem::last_write_time(folder / "path.ply", error);
  if (!error && kept_.bytes && kept_.folder == folder && kept_.written == written)
    return kept_.bytes;
  kept_ = {};
  auto plan = INTAGLIO_TRY(ReadPlan(folder));
  kept_ = {folder, written, std::make_shared<const std::string>(std::move(plan))};
  return kept_.bytes;
}

}  // namespace intaglio::console
