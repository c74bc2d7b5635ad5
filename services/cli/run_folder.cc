#include "services/cli/run_folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <random>

#include "engrave/core/try.h"
#include "services/cli/proofs/report_text.h"
#include "services/client/proof/evidence/proof_pictures.h"

namespace intaglio::cli {

namespace fs = std::filesystem;

namespace {

const char* FilesOf(const JobReport& report) {
  if (report.marks().has_cut()) return "marks.bin, cut.rec, sheet.png";
  return report.has_marks() ? "marks.bin, burnt.rec" : "glass.ply, path.ply";
}

}  // namespace

Status PrepareRunFolder(const fs::path& out, const fs::path& session) {
  std::error_code error;
  fs::remove_all(session, error);
  for (const char* file :
       {"report.json", "glass.ply", "path.ply", "views.png", "customer.png",
        "journal.bin", "job.json", "marks.bin", "burnt.rec", "cut.rec", "sheet.png"}) {
    fs::remove(out / file, error);
  }
  const std::string recordings = session.filename().string();
  for (const auto& entry : fs::directory_iterator(out, error)) {
    const fs::path& file = entry.path();
    const std::string stem = file.stem().string(), kind = file.extension().string();
    if ((kind == ".mcap" && stem.starts_with(recordings)) ||
        (kind == ".png" && stem.starts_with("views-channel-"))) {
      fs::remove(file, error);
    }
  }
  fs::create_directories(session, error);
  if (!error) return {};
  return Fail(
      ErrorCode::kIo,
      fmt::format("--out {}: cannot make the folder: {}", out.string(), error.message()),
      out.string());
}

std::string PrivateTag() {
  std::random_device random;
  return fmt::format("run-{}-{:08x}", getpid(), random());
}

Status PresentProof(std::ostream& human, const JobReport& report, const fs::path& out,
                    bool is_recorded, const CustomerPictureFlags& picture) {
  human << SummaryOf(report) << "\n";
  human << "folder      " << out.string() << "  (report.json, " << FilesOf(report)
        << ", views.png" << (is_recorded ? ", session.mcap)\n" : ")\n");
  if (!picture.asked() || report.has_marks()) return {};
  const fs::path file = picture.FileIn(out);
  INTAGLIO_TRY(client::WriteCustomerPicture(file, out, picture.Picture()));
  human << "picture     " << file.string() << "\n";
  return {};
}

}  // namespace intaglio::cli
