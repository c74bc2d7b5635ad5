#pragma once

// The folders of a cell's jobs, completed by this process (client::ShopProofs) as `up`
// and `proofs` do it: what a person should know goes to the standard error stream.

#include <filesystem>
#include <span>
#include <string>

#include "services/cli/flags/customer_picture_flags.h"
#include "services/client/job_client.h"
#include "services/client/proof/shop_proofs.h"

namespace intaglio::cli {

/// `folder`: of proof.log and of the virtual engraver's glass records.
client::ShopProofs ProofsOf(const std::filesystem::path& folder, const std::string& cell,
                            const CustomerPictureFlags& picture);

/// Turns those of all cells of this process, two at a time. Never waits.
void TurnProofs(std::span<client::ShopProofs> cells, const client::JobClient& client);

/// Completes the folders of the jobs that have just ended, for eight seconds at most;
/// another Ctrl-C leaves them to the next start.
void FinishProofs(std::span<client::ShopProofs> cells, client::JobClient& client);

}  // namespace intaglio::cli
