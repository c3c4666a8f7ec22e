// SPDX-License-Identifier: BSD-3-Clause
// JSON files about the instances of a scene: their boxes, and their masks in
// pictures in the form of COCO's data set.

#ifndef FREEGS_STAGES_EXPORT_INSTANCE_FILES_H_
#define FREEGS_STAGES_EXPORT_INSTANCE_FILES_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/image.h"
#include "semantics/instances/instances.h"
#include "stages/export/label_masks.h"

namespace freegs::stages {

// The best word of an instance, or "instance 3".
std::string InstanceName(const semantics::Instance& instance);

// The boxes in the form of an object file (stages/evaluation/ground_truth.h),
// in the world frame.
std::string BoxesJson(const std::vector<semantics::Instance>& instances);

// Collects masks, picture by picture, for a file of COCO's instance form:
//   "images"       id, file_name, width, height
//   "annotations"  id, image_id, category_id, segmentation ("size": [height,
//                  width] and "counts", the compressed text of label_masks.h),
//                  area, bbox [left, top, width, height] in pixels, iscrowd 0,
//                  and, which COCO has not, instance_id, the same in all
//                  pictures, and background
//   "categories"   id, name: the best words of the instances; those without
//                  words are of category "object"
// All ids begin at 1.
class CocoMasks {
 public:
  // Labels of other instances than these get no annotation.
  explicit CocoMasks(std::vector<semantics::Instance> instances);

  // `labels`: H x W x 1, instance id - 1 or -1.
  void AddPicture(const std::string& file_name, const Image<int32_t>& labels);

  size_t num_annotations() const { return annotations_.size(); }
  std::string Json() const;

 private:
  struct Picture {
    std::string file_name;
    int width = 0;
    int height = 0;
  };
  struct Annotation {
    size_t picture = 0;
    size_t instance = 0;
    LabelMask mask;
  };

  const std::vector<semantics::Instance> instances_;
  std::map<int32_t, size_t> instance_of_label_;
  std::vector<Picture> pictures_;
  std::vector<Annotation> annotations_;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_INSTANCE_FILES_H_
