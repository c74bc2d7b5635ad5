#include "services/cli/proofs/cell_proofs.h"

#include <algorithm>
#include <chrono>
#include <iostream>
#include <numeric>

#include "engrave/core/counted.h"
#include "services/cli/terminal/interrupt.h"
#include "services/platform/command_line/other_programs.h"

namespace intaglio::cli {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

// A job of 300 000 points takes four seconds.
constexpr auto kProofTime = 8s;
// Each may need some hundred MB.
constexpr std::ptrdiff_t kProofsAtATime = 2;

std::size_t PendingCount(std::span<client::ShopProofs> cells) {
  return std::accumulate(
      cells.begin(), cells.end(), std::size_t{0},
      [](std::size_t sum, const auto& cell) { return sum + cell.pending_count(); });
}

}  // namespace

client::ShopProofs ProofsOf(const std::filesystem::path& folder, const std::string& cell,
                            const CustomerPictureFlags& picture) {
  return client::ShopProofs({folder,
                             cell,
                             command_line::ProgramFolder() / "intaglio",
                             {"--background", picture.background, "--picture-size",
                              std::to_string(picture.size_px)}});
}

void TurnProofs(std::span<client::ShopProofs> cells, const client::JobClient& client) {
  for (client::ShopProofs& cell : cells) {
    const auto at_work = std::ranges::count_if(cells, &client::ShopProofs::at_work);
    if (!cell.at_work() && at_work >= kProofsAtATime) continue;
    for (const std::string& sentence : cell.Turn(ViewOf(client), Clock::now())) {
      std::cerr << sentence << "\n";
    }
  }
}

void FinishProofs(std::span<client::ShopProofs> cells, client::JobClient& client) {
  client.Poll(100ms);  // an end that has just come
  TurnProofs(cells, client);
  if (PendingCount(cells) == 0) return;
  std::cerr << "making report and pictures of " << Counted(PendingCount(cells), "job")
            << "\n";
  const auto end = Clock::now() + kProofTime;
  while (PendingCount(cells) > 0 && Interrupts() < 2 && Clock::now() < end) {
    client.Poll(100ms);
    TurnProofs(cells, client);
  }
}

}  // namespace intaglio::cli
