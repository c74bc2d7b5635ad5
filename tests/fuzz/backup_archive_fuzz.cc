// Any bytes as the archive of a backup: an error with a message that names the file, or
// files that can all be extracted with the sizes that are listed.

#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "services/backup/archive.h"

namespace {

using namespace intaglio;
namespace fs = std::filesystem;

const fs::path& Folder() {
  static const fs::path folder =
      fs::temp_directory_path() / ("backup_archive_fuzz" + std::to_string(getpid()));
  fs::create_directories(folder);
  return folder;
}

void Try(const fs::path& file) {
  const auto archive = backup::Archive::Open(file);
  if (!archive) {
    if (archive.error().message.find(file.string()) == std::string::npos) std::abort();
    return;
  }
  for (std::size_t i = 0; i < archive->files().size(); ++i) {
    if (!backup::IsArchiveName(archive->files()[i].name)) std::abort();
    const fs::path target = Folder() / "out";
    if (!archive->Extract(i, target)) std::abort();
    if (fs::file_size(target) != archive->files()[i].bytes) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const fs::path file = Folder() / "archive";
  std::ofstream(file, std::ios::binary | std::ios::trunc)
      .write(reinterpret_cast<const char*>(bytes), static_cast<std::streamsize>(size));
  Try(file);
  return 0;
}
