// SPDX-License-Identifier: BSD-3-Clause
// Photographs, masks, films, and the list of photographs.

#include <algorithm>

#include <opencv2/videoio.hpp>

#include "core/io/image_io.h"
#include "photos/film_rotation.h"
#include "photos/photo_decode.h"
#include "photos/photo_list.h"
#include "photos/photo_mask.h"
#include "photos/video_frames.h"
#include "tests/fuzz/reader.h"
#include "tests/photos/film_test_files.h"
#include "tests/photos/photo_test_files.h"

namespace freegs::fuzz {
namespace {

// Small pictures, so that the fuzzer tries many.
photos::PhotoDecodeOptions OptionsOfSmallPhotos() {
  photos::PhotoDecodeOptions options;
  options.max_megapixels = 0.1;
  options.min_side = 4;
  return options;
}

std::vector<std::string> Pictures() {
  const std::string jpeg = photos::MakeJpeg(24, 16, 1);
  cv::Mat alpha(9, 7, CV_8UC4, cv::Scalar(10, 200, 30, 128));
  cv::Mat deep(9, 7, CV_16UC3, cv::Scalar(1000, 20000, 65535));
  cv::Mat grey(9, 7, CV_8UC1, cv::Scalar(200));
  return {jpeg,
          photos::WithExif(jpeg,
                           photos::MakeExif({.orientation = 6,
                                             .make = "Maker",
                                             .model = "Model",
                                             .focal_mm_tenths = 350,
                                             .focal_35mm = 50,
                                             .focal_plane_per_cm = 2000,
                                             .pixel_width = 24,
                                             .pixel_height = 16,
                                             .gps = true})),
          photos::Encode(".jpg",
                         photos::MakePicture(24, 16, 2),
                         {cv::IMWRITE_JPEG_PROGRESSIVE, 1}),
          photos::MakePng(9, 7, 1),
          photos::WithPngDataInTwo(
              photos::WithPngChunk(
                  photos::MakePng(9, 7, 4), "tEXt", std::string("a\0b", 3)),
              ""),
          photos::Encode(".png", alpha),
          photos::Encode(".png", deep),
          photos::Encode(".png", grey),
          photos::Encode(".tif", photos::MakePicture(9, 7, 3)),
          photos::Encode(".tif", alpha),
          photos::Encode(".tif", deep, {cv::IMWRITE_TIFF_COMPRESSION, 1})};
}

// Stage ingest copies plain photos, and all later stages must read them as it
// did. Two decoders of a JPEG may round differently.
void RequireSamePixels(std::string_view png, const ImageU8& pixels) {
  WriteText(Scratch() / "photo.png", png);
  const auto read = ReadRgb(Scratch() / "photo.png");
  Require(read.ok() && read->width() == pixels.width() &&
          std::equal(pixels.data(),
                     pixels.data() + pixels.size(),
                     read->data(),
                     read->data() + read->size()));
}

}  // namespace

Reader Photo() {
  return {[](std::string_view bytes) {
            const auto header = photos::ParsePhotoHeader(bytes);
            if (!header.ok()) return;
            (void)photos::FocalLengthPixels(header->exif, 24, 16);
            const photos::PhotoDecodeOptions options = OptionsOfSmallPhotos();
            if (!photos::CheckHeader(*header, options).ok()) return;
            const auto pixels = photos::DecodePhoto(bytes, *header, options);
            if (!pixels.ok()) return;
            // EXIF may turn it.
            Require(pixels->num_pixels() ==
                    static_cast<size_t>(header->width * header->height));
            if (header->format == photos::PhotoFormat::kPng &&
                photos::IsPlainPhoto(*header)) {
              RequireSamePixels(bytes, *pixels);
            }
          },
          Pictures};
}

Reader Mask() {
  return {[](std::string_view bytes) {
            photos::Photo photo;
            photo.width = 16;
            photo.height = 24;
            photo.orientation = 6;
            const auto mask =
                photos::DecodeMask(bytes, photo, false, OptionsOfSmallPhotos());
            if (!mask.ok()) return;
            Require(mask->width() == 16 && mask->height() == 24);
          },
          Pictures};
}

// Pictures of the workspace, of data sets and of examples.
Reader ImageFile() {
  return {[](std::string_view bytes) {
            WriteText(Scratch() / "image", bytes);
            (void)ReadRgb(Scratch() / "image");
            (void)ReadLabels(Scratch() / "image");
          },
          Pictures};
}

Reader Film() {
  return {[](std::string_view bytes) {
            (void)photos::LooksLikeVideo(bytes);
            (void)photos::MovieRotation(bytes);
            WriteText(Scratch() / "film.avi", bytes);
            (void)photos::FilmRotation(Scratch() / "film.avi");
            photos::VideoFrameOptions options;
            options.max_megapixels = 0.1;
            (void)photos::SurveyVideo(
                Scratch() / "film.avi", options, nullptr, nullptr);
          },
          [] {
            photos::WriteFilm(Scratch() / "seed.avi", photos::MovingFrames(2));
            return std::vector<std::string>{ReadText(Scratch() / "seed.avi"),
                                            std::string("\0\0\0\x14"
                                                        "ftypisom\0\0\0\0isom"
                                                        "\0\0\0\x08moov",
                                                        28)};
          }};
}

Reader PhotoList() {
  return {[](std::string_view bytes) {
            const auto list = photos::ParsePhotoList(bytes, "images.json");
            if (!list.ok()) return;
            const auto path = Scratch() / "images.json";
            Require(photos::WritePhotoList(path, *list).ok());
            Require(photos::ReadPhotoList(path).ok());
          },
          [] {
            photos::PhotoList list;
            list.images_folder = "photos";
            list.photos.resize(2);
            photos::Photo& photo = list.photos[0];
            photo.file = photo.name = "a.jpg";
            photo.format = "JPEG";
            photo.width = 24;
            photo.height = 16;
            photo.hash = photo.file_hash = std::string(32, '0');
            photo.camera_group = 0;
            photo.focal_length_mm = 35;
            list.photos[1].file = "b.jpg";
            list.photos[1].split = photos::PhotoSplit::kRejected;
            list.photos[1].reason = "empty";
            const auto path = Scratch() / "images.json";
            Require(photos::WritePhotoList(path, list).ok());
            return std::vector<std::string>{ReadText(path)};
          }};
}

}  // namespace freegs::fuzz
