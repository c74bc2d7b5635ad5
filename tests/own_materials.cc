// Keeps the tests off the user's material base: in every test program, and for the
// children that it starts, INTAGLIO_MATERIALS_DB names a base of the process's own. A
// build that is newer than the installed one would migrate the user's base, which the
// installed programs then refuse, and glasses that the user has added would change what
// the tests find.

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <string>

namespace intaglio::test {
namespace {

namespace fs = std::filesystem;

/// The base of a process. A child of a test keeps the base of its parent, or the one that
/// the case has named; a base outside the build tree is never kept.
class OwnMaterials {
 public:
  OwnMaterials() {
    constexpr char kVariable[] = "INTAGLIO_MATERIALS_DB";
    const std::string folder = INTAGLIO_TEST_DIR;
    const char* named = std::getenv(kVariable);
    if (named != nullptr && std::string(named).starts_with(folder + "/")) return;
    file_ = fmt::format("{}/own_materials/{}-{}.db", folder,
                        program_invocation_short_name, getpid());
    Remove();
    setenv(kVariable, file_.c_str(), 1);
  }
  /// A fork of the process does not remove the base of its parent.
  ~OwnMaterials() {
    if (!file_.empty() && getpid() == owner_) Remove();
  }
  OwnMaterials(const OwnMaterials&) = delete;
  OwnMaterials& operator=(const OwnMaterials&) = delete;

 private:
  void Remove() const {
    std::error_code ignored;
    for (const char* part : {"", "-journal", "-wal", "-shm"}) {
      fs::remove(file_ + part, ignored);
    }
  }

  const pid_t owner_ = getpid();
  std::string file_;
};

const OwnMaterials kOwnMaterials;

}  // namespace
}  // namespace intaglio::test
