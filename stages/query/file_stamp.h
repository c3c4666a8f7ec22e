// SPDX-License-Identifier: BSD-3-Clause
// Notices that files of a workspace were replaced.

#ifndef FREEGS_STAGES_QUERY_FILE_STAMP_H_
#define FREEGS_STAGES_QUERY_FILE_STAMP_H_

#include <filesystem>
#include <string>
#include <vector>

namespace freegs::stages {

// A short text of letters and digits that changes when one of the files is
// replaced, written, made or deleted. It is found from their numbers, sizes and
// times, without reading them. Folders stand for themselves only.
std::string FileStamp(const std::vector<std::filesystem::path>& files);

// The stamp of what ReadPosedPhotos reads (stages/scene/training_scene.h).
std::string PhotosStamp(const std::filesystem::path& workspace);

// The stamp of all that a question or the 3D viewer depends on.
std::string QueryStamp(const std::filesystem::path& workspace);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_QUERY_FILE_STAMP_H_
