// SPDX-License-Identifier: BSD-3-Clause
// Features of a photo by the scale-invariant feature transform (SIFT; Lowe,
// "Distinctive image features from scale-invariant keypoints", IJCV 2004), as
// OpenCV computes them. COLMAP's own take four times as long on a processor;
// docs/sfm.md compares the poses.

#ifndef FREEGS_SFM_FEATURES_SIFT_H_
#define FREEGS_SFM_FEATURES_SIFT_H_

#include <filesystem>
#include <vector>

#include "core/image.h"
#include "core/status.h"
#include "sfm/matching/descriptor_matching.h"
#include "sfm/matching/match_database.h"

namespace freegs::sfm {

struct SiftFeatures {
  std::vector<Keypoint> keypoints;  // The largest first.
  SiftDescriptors descriptors;      // One for each keypoint.
};

// Returns the max_features largest features of an RGB image. The descriptors
// are scaled as COLMAP's: square roots of shares of the sum (RootSIFT;
// Arandjelovic and Zisserman, CVPR 2012), 512 long and at most 255. Features at
// which the mask is 0 do not count. The mask shows the whole image in any size;
// an empty one keeps all.
SiftFeatures FindSift(const ImageU8& rgb,
                      int max_features,
                      const ImageU16& mask = {});

// Does the same for a photo that is first made smaller until its longest side
// has at most max_image_size pixels; keypoints are in pixels of the photo.
// Where the mask is 0 there are no features. `mask` is an image file as large
// as the photo, or empty.
StatusOr<SiftFeatures> FindPhotoSift(const std::filesystem::path& photo,
                                     const std::filesystem::path& mask,
                                     int max_image_size,
                                     int max_features);

// While it lives, OpenCV uses no threads of its own. For work that already runs
// on all threads.
class OneOpenCvThread {
 public:
  OneOpenCvThread();
  ~OneOpenCvThread();
  OneOpenCvThread(const OneOpenCvThread&) = delete;
  OneOpenCvThread& operator=(const OneOpenCvThread&) = delete;

 private:
  int before_;
};

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_FEATURES_SIFT_H_
