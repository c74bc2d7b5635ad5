#include "tests/engrave/matrix_code/code_reader.h"

#ifdef INTAGLIO_HAS_DMTX
#include <dmtx.h>
#endif
#ifdef INTAGLIO_HAS_ZBAR
#include <zbar.h>
#endif

namespace intaglio::matrix_code {

bool CanReadDataMatrix() {
#ifdef INTAGLIO_HAS_DMTX
  return true;
#else
  return false;
#endif
}

bool CanReadQr() {
#ifdef INTAGLIO_HAS_ZBAR
  return true;
#else
  return false;
#endif
}

std::optional<std::string> ReadDataMatrix([[maybe_unused]] mark::BurntPicture picture) {
  std::optional<std::string> text;
#ifdef INTAGLIO_HAS_DMTX
  DmtxImage* image = dmtxImageCreate(picture.pixels.data(), picture.width, picture.height,
                                     DmtxPack8bppK);
  DmtxDecode* decode = dmtxDecodeCreate(image, 1);
  // Every code has its own shape of noise: all regions are tried.
  while (DmtxRegion* region = dmtxRegionFindNext(decode, nullptr)) {
    DmtxMessage* message = dmtxDecodeMatrixRegion(decode, region, DmtxUndefined);
    if (message != nullptr) {
      text.emplace(reinterpret_cast<const char*>(message->output),
                   static_cast<std::size_t>(message->outputIdx));
      dmtxMessageDestroy(&message);
    }
    dmtxRegionDestroy(&region);
    if (text) break;
  }
  dmtxDecodeDestroy(&decode);
  dmtxImageDestroy(&image);
#endif
  return text;
}

std::optional<std::string> ReadQr([[maybe_unused]] mark::BurntPicture picture) {
  std::optional<std::string> text;
#ifdef INTAGLIO_HAS_ZBAR
  zbar::zbar_image_scanner_t* scanner = zbar::zbar_image_scanner_create();
  zbar::zbar_image_t* image = zbar::zbar_image_create();
  zbar::zbar_image_set_format(image, zbar_fourcc('Y', '8', '0', '0'));
  zbar::zbar_image_set_size(image, static_cast<unsigned>(picture.width),
                            static_cast<unsigned>(picture.height));
  zbar::zbar_image_set_data(image, picture.pixels.data(), picture.pixels.size(), nullptr);
  zbar::zbar_scan_image(scanner, image);
  const zbar::zbar_symbol_t* symbol = zbar::zbar_image_first_symbol(image);
  if (symbol != nullptr)
    text.emplace(zbar::zbar_symbol_get_data(symbol),
                 zbar::zbar_symbol_get_data_length(symbol));
  zbar::zbar_image_destroy(image);
  zbar::zbar_image_scanner_destroy(scanner);
#endif
  return text;
}

}  // namespace intaglio::matrix_code
