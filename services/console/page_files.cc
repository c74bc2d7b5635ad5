#include "services/console/page_files.h"

// INTAGLIO_PAGE_FOLDER has the bundle.
#define EMBED(name, file)                                                        \
  asm(".section .rodata\n.global console_" #name "\nconsole_" #name              \
      ":\n.incbin \"" INTAGLIO_PAGE_FOLDER "/" file "\"\n.global console_" #name \
      "_end\nconsole_" #name "_end:\n.byte 0\n.previous\n");                     \
  extern "C" const char console_##name[], console_##name##_end[]

EMBED(index, "index.html");
EMBED(style, "style.css");
EMBED(main, "main.js");
EMBED(view, "view.js");

namespace intaglio::console {
namespace {

web::Response FileOf(const char* type, const char* begin, const char* end) {
  return web::TextResponse(200, type, std::string(begin, end));
}

}  // namespace

std::map<std::string, web::Response> PageFiles() {
  return {
      {"/", FileOf("text/html; charset=utf-8", console_index, console_index_end)},
      {"/style.css", FileOf("text/css; charset=utf-8", console_style, console_style_end)},
      {"/main.js",
       FileOf("text/javascript; charset=utf-8", console_main, console_main_end)},
      {"/view.js",
       FileOf("text/javascript; charset=utf-8", console_view, console_view_end)}};
}

}  // namespace intaglio::console
