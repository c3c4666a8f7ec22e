// SPDX-License-Identifier: BSD-3-Clause

#ifndef FREEGS_TESTS_RANDOM_IMAGE_H_
#define FREEGS_TESTS_RANDOM_IMAGE_H_

#include <cstddef>
#include <cstdint>

#include "core/image.h"
#include "core/random.h"

namespace freegs {

// Values from 0 to 1.
inline ImageF RandomImage(int width, int height, int channels, uint64_t seed) {
  ImageF image(width, height, channels);
  for (size_t i = 0; i < image.size(); ++i) {
    image.data()[i] = static_cast<float>(RandomUniform(seed, 0, i));
  }
  return image;
}

}  // namespace freegs

#endif  // FREEGS_TESTS_RANDOM_IMAGE_H_
