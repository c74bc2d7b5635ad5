#include "services/cli/proofs/cell_proofs.h"

#include <chrono>
#include <iostream>

#include "engrave/core/counted.h"
#include "services/cli/interrupt.h"
#include "services/platform/command_line/other_programs.h"

namespace intaglio::cli {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

// A job of 300 000 points takes four seconds.
constexpr auto kProofTime = 8s;

}  // namespace

client::ShopProofs ProofsOf(const std::filesystem::path& folder, const std::string& cell,
                            const CustomerPictureFlags& picture) {
  return client::ShopProofs({folder,
                             cell,
                             command_line::ProgramFolder() / "intaglio",
                             {"--background", picture.background, "--picture-size",
                              std::to_string(picture.size_px)}});
}

void TurnProofs(client::ShopProofs& proofs, const client::JobClient& client) {
  for (const std::string& sentence : proofs.Turn(ViewOf(client), Clock::now())) {
    std::cerr << sentence << "\n";
  }
}

void FinishProofs(client::ShopProofs& proofs, client::JobClient& client) {
  client.Poll(100ms);  // an end that has just come
  TurnProofs(proofs, client);
  if (proofs.pending_count() == 0) return;
  std::cerr << "making report and pictures of " << Counted(proofs.pending_count(), "job")
            << "\n";
  const auto end = Clock::now() + kProofTime;
  while (proofs.pending_count() > 0 && Interrupts() < 2 && Clock::now() < end) {
    client.Poll(100ms);
    TurnProofs(proofs, client);
  }
}

}  // namespace intaglio::cli
