// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_jpeg.h"

#include <csetjmp>
#include <cstdio>
#include <jpeglib.h>
#include <new>
#include <string>
#include <vector>
// After jpeglib.h, which it needs.
#include <jerror.h>

namespace freegs::photos {
namespace {

// A progressive file can ask for the whole picture to be worked on again for
// every few bytes. Real ones have about ten scans.
constexpr int kMaxScans = 200;

// Owns a decompressor. libjpeg leaves by longjmp on errors, so the functions
// that call it hold nothing that needs a destructor.
class Decompressor {
 public:
  Decompressor() {
    info_.err = jpeg_std_error(&errors_);
    errors_.error_exit = &OnError;
    errors_.emit_message = &OnMessage;
    errors_.output_message = [](j_common_ptr) {};
    progress_.progress_monitor = &OnProgress;
    info_.client_data = this;
  }
  ~Decompressor() { jpeg_destroy_decompress(&info_); }
  Decompressor(const Decompressor&) = delete;
  Decompressor& operator=(const Decompressor&) = delete;

  // Reads what stands before the pixels, and takes no memory for them yet.
  bool ReadHeader(std::string_view bytes) {
    if (setjmp(jump_) != 0) return false;
    jpeg_create_decompress(&info_);
    info_.client_data = this;
    info_.progress = &progress_;
    jpeg_mem_src(&info_,
                 reinterpret_cast<const unsigned char*>(bytes.data()),
                 static_cast<unsigned long>(bytes.size()));
    jpeg_read_header(&info_, TRUE);
    return true;
  }

  bool HasSize(int64_t width, int64_t height) const {
    return info_.image_width == width && info_.image_height == height;
  }

  bool Start() {
    if (setjmp(jump_) != 0) return false;
    const bool cmyk = info_.num_components == 4;
    info_.out_color_space = cmyk ? JCS_CMYK : JCS_RGB;
    jpeg_start_decompress(&info_);
    return true;
  }

  // `row` holds width() * samples() values.
  bool ReadRow(uint8_t* row) {
    if (setjmp(jump_) != 0) return false;
    return jpeg_read_scanlines(&info_, &row, 1) == 1;
  }

  bool Finish() {
    if (setjmp(jump_) != 0) return false;
    jpeg_finish_decompress(&info_);
    return true;
  }

  int width() const { return static_cast<int>(info_.output_width); }
  int height() const { return static_cast<int>(info_.output_height); }
  int samples() const { return info_.output_components; }
  // Adobe's programs store ink as 255 - ink.
  bool inverted_cmyk() const { return info_.saw_Adobe_marker != 0; }
  bool damaged() const { return damaged_; }
  bool out_of_memory() const { return errors_.msg_code == JERR_OUT_OF_MEMORY; }
  const char* message() const { return message_; }

 private:
  static Decompressor* Self(j_common_ptr info) {
    return static_cast<Decompressor*>(info->client_data);
  }

  static void OnError(j_common_ptr info) {
    Decompressor* self = Self(info);
    info->err->format_message(info, self->message_);
    longjmp(self->jump_, 1);
  }

  static void OnMessage(j_common_ptr info, int level) {
    if (level >= 0) return;
    switch (info->err->msg_code) {
      case JWRN_JPEG_EOF:
      case JWRN_HIT_MARKER:
      case JWRN_HUFF_BAD_CODE:
      case JWRN_ARITH_BAD_CODE:
      case JWRN_MUST_RESYNC: {
        Decompressor* self = Self(info);
        if (self->damaged_) return;
        self->damaged_ = true;
        info->err->format_message(info, self->message_);
        return;
      }
      default:
        return;  // Odd but harmless, such as bytes between segments.
    }
  }

  static void OnProgress(j_common_ptr info) {
    Decompressor* self = Self(info);
    if (self->info_.input_scan_number <= kMaxScans) return;
    std::snprintf(self->message_, sizeof(self->message_), "too many scans");
    longjmp(self->jump_, 1);
  }

  jpeg_decompress_struct info_ = {};
  jpeg_error_mgr errors_ = {};
  jpeg_progress_mgr progress_ = {};
  std::jmp_buf jump_ = {};
  char message_[JMSG_LENGTH_MAX] = {};
  bool damaged_ = false;
};

Status Damaged(const Decompressor& decompressor) {
  if (decompressor.out_of_memory()) throw std::bad_alloc();
  return BadInputError("damaged JPEG (" + std::string(decompressor.message()) +
                       "); copy the file again");
}

// Ink amounts to light: what remains after black and the colour are absorbed.
void CmykToRgb(const std::vector<uint8_t>& cmyk, bool inverted, uint8_t* rgb) {
  for (size_t x = 0; x < cmyk.size() / 4; ++x) {
    const uint8_t* ink = cmyk.data() + 4 * x;
    const int black = inverted ? ink[3] : 255 - ink[3];
    for (int c = 0; c < 3; ++c) {
      const int light = inverted ? ink[c] : 255 - ink[c];
      rgb[3 * x + c] = static_cast<uint8_t>((light * black + 127) / 255);
    }
  }
}

}  // namespace

StatusOr<ImageU8> DecodeJpeg(std::string_view bytes,
                             const PhotoHeader& header) {
  Decompressor decompressor;
  if (!decompressor.ReadHeader(bytes)) return Damaged(decompressor);
  if (!decompressor.HasSize(header.width, header.height)) {
    return BadInputError(
        "damaged JPEG: it says two sizes of itself; copy the file again");
  }
  if (!decompressor.Start()) return Damaged(decompressor);
  ImageU8 image(decompressor.width(), decompressor.height(), 3);
  std::vector<uint8_t> cmyk;
  if (decompressor.samples() == 4) cmyk.resize(size_t{4} * image.width());
  for (int y = 0; y < image.height(); ++y) {
    uint8_t* row = cmyk.empty() ? image.row(y) : cmyk.data();
    if (!decompressor.ReadRow(row)) return Damaged(decompressor);
    if (!cmyk.empty()) {
      CmykToRgb(cmyk, decompressor.inverted_cmyk(), image.row(y));
    }
  }
  if (!decompressor.Finish() || decompressor.damaged()) {
    return Damaged(decompressor);
  }
  return image;
}

}  // namespace freegs::photos
