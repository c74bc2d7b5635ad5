#include "services/platform/command_line/shell_files.h"

#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "services/platform/command_line/completion.h"
#include "services/platform/command_line/man_page.h"

namespace intaglio::command_line {
namespace {

Status WriteText(const std::filesystem::path& file, const std::string& text) {
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  return io::WriteFileAtomically(file, std::string_view(text));
}

}  // namespace

Status WriteShellFiles(const std::string& program, const CommandDescription& description,
                       const std::filesystem::path& share) {
  for (const ManPage& page : ManPagesOf(program, description))
    INTAGLIO_TRY(WriteText(share / "man/man1" / page.file_name, page.text));
  INTAGLIO_TRY(WriteText(share / "bash-completion/completions" / program,
                         BashCompletion(program, description)));
  INTAGLIO_TRY(WriteText(share / "zsh/site-functions" / ("_" + program),
                         ZshCompletion(program, description)));
  return WriteText(share / "fish/vendor_completions.d" / (program + ".fish"),
                   FishCompletion(program, description));
}

}  // namespace intaglio::command_line
