// SPDX-License-Identifier: BSD-3-Clause
// Reads and changes COLMAP's SQLite database of features and matches, where the
// commands of COLMAP do not suffice.

#ifndef FREEGS_SFM_MATCHING_MATCH_DATABASE_H_
#define FREEGS_SFM_MATCHING_MATCH_DATABASE_H_

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/status.h"
#include "sfm/matching/descriptor_matching.h"

struct sqlite3;

namespace freegs::sfm {

// Feature number feature1 of one image and number feature2 of another show the
// same thing.
struct FeatureMatch {
  uint32_t feature1 = 0;
  uint32_t feature2 = 0;
};

// A feature of a photo: where it is, how large, and which way it is turned.
struct Keypoint {
  float x = 0;      // Pixels, from the left edge of the photo.
  float y = 0;      // Pixels, from its top edge.
  float scale = 0;  // Pixels: the standard deviation of the blur.
  float angle = 0;  // Radians, from x towards y.
};

// The features of a photo, for MatchDatabase::AddFeatures.
struct PhotoKeypoints {
  uint32_t photo_id = 0;
  const std::vector<Keypoint>* keypoints = nullptr;
  const SiftDescriptors* descriptors = nullptr;  // One for each keypoint.
};

// What is known of a photo's camera, for MatchDatabase::SetCameras.
struct PhotoCamera {
  uint32_t photo_id = 0;
  int width = 0;               // Pixels.
  int height = 0;              // Pixels.
  int model = 0;               // COLMAP's number of the camera model.
  std::vector<double> params;  // As its camera model orders them.
  bool focal_known = false;    // Whether the focal length is more than a guess.
};

// An open database:
//
//   FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
//                           MatchDatabase::Open(work_folder / "database.db"));
//   FREEGS_ASSIGN_OR_RETURN(const auto photos, database.Photos());
//   FREEGS_ASSIGN_OR_RETURN(const auto pairs, database.VerifiedPairs());
//
// Errors name the file.
class MatchDatabase {
 public:
  struct Photo {
    uint32_t id = 0;
    std::string name;
    int64_t num_features = 0;
  };

  // Opens an existing database of COLMAP.
  static StatusOr<MatchDatabase> Open(const std::filesystem::path& path);

  // The photos in the order of their ids.
  StatusOr<std::vector<Photo>> Photos() const;

  // The ids of the photos by their names.
  StatusOr<std::map<std::string, uint32_t>> PhotoIds() const;

  // The ids of the photos' cameras by the names of the photos.
  StatusOr<std::map<std::string, uint32_t>> CameraIds() const;

  // The SIFT descriptors of a photo; none when it has no features. Returns
  // kBadInput when they are of another kind.
  StatusOr<SiftDescriptors> Descriptors(uint32_t photo_id) const;

  // The scales of a photo's features, in pixels and never NaN, in the order of
  // its descriptors; empty when it has none or the database does not tell them.
  StatusOr<std::vector<float>> FeatureScales(uint32_t photo_id) const;

  // The positions of a photo's features, in pixels from its top left corner and
  // finite, in the order of its descriptors; empty when it has none.
  StatusOr<std::vector<Eigen::Vector2f>> FeaturePositions(
      uint32_t photo_id) const;

  // Gives the cameras of photos their size, model and parameters, in one
  // transaction. Of photos that share a camera the last one counts.
  Status SetCameras(std::span<const PhotoCamera> cameras);

  // Gives photos their features, in one transaction. Features that they had are
  // replaced.
  Status AddFeatures(std::span<const PhotoKeypoints> photos);

  // Deletes the features of all photos.
  Status ClearFeatures();

  // A pair of photos with verified matches, and the motion that fits them.
  struct VerifiedPair {
    uint32_t id1 = 0;  // Smaller than id2.
    uint32_t id2 = 0;
    int64_t num_matches = 0;

    // Whether a homography explains the matches as well as any motion does.
    // Then both photos show one plane, or the camera only turned between them.
    bool is_homography = false;

    // The homography that explains most of the matches, whether many or few. It
    // maps pixels of id1 to pixels of id2; the database need not have it.
    std::optional<Eigen::Matrix3d> homography;

    // The fundamental matrix F with x2^T F x1 = 0 for the pixels x1 of id1 and
    // x2 of id2, in homogeneous coordinates; the database need not have it.
    std::optional<Eigen::Matrix3d> fundamental;
  };

  // All pairs with verified matches, in the order of their ids. Details that
  // the database does not have are left out.
  StatusOr<std::vector<VerifiedPair>> VerifiedPairs() const;

  // The ids, the smaller one first, of all pairs of photos that were compared,
  // whether any matches of theirs were verified or not.
  StatusOr<std::set<std::pair<uint32_t, uint32_t>>> ComparedPairs() const;

  // Calls visit(id1, id2, matches), where id1 < id2, for each pair of photos
  // with verified matches, in the order of the ids.
  Status ForEachVerifiedPair(
      const std::function<void(
          uint32_t, uint32_t, std::span<const FeatureMatch>)>& visit) const;

  // Deletes the verified matches of the given pairs.
  Status RemoveVerifiedPairs(
      const std::vector<std::pair<uint32_t, uint32_t>>& pairs);

  // Copies all raw and verified matches of the database at `other` into this
  // one, in one transaction. Both must have the same photos with the same ids.
  // Matches of a pair that is already here are replaced.
  Status CopyMatchesFrom(const std::filesystem::path& other);

  // Writes the present content of this database into a new file.
  Status CopyTo(const std::filesystem::path& path) const;

  // Changes the name of every photo to name(id).
  Status RenamePhotos(const std::function<std::string(uint32_t id)>& name);

  // Deletes all descriptors and matches. Photos, cameras and the positions of
  // features stay.
  Status ClearMatchesAndDescriptors();

 private:
  struct Closer {
    void operator()(sqlite3* database) const;
  };
  Status Execute(const std::string& sql) const;
  // The two photos of a pair by its number; kBadInput if it is none that COLMAP
  // writes.
  StatusOr<std::pair<uint32_t, uint32_t>> IdsOf(int64_t pair) const;
  // The keypoints of a photo, row by row.
  struct KeypointTable {
    size_t columns = 2;  // 2: x, y; 4: also scale, angle; 6: a 2 x 2 matrix.
    std::vector<float> values;
  };
  StatusOr<KeypointTable> ReadKeypoints(uint32_t photo_id) const;

  bool HasColumn(const char* table, const char* column) const;
  Status Error(const std::string& what) const;
  Status WrongSize(uint32_t id1, uint32_t id2) const;

  std::filesystem::path path_;
  std::unique_ptr<sqlite3, Closer> database_;
};

// Copies a database into a file, which is replaced if it exists.
Status CopyDatabase(const std::filesystem::path& from,
                    const std::filesystem::path& to);

// Opens the database and calls MatchDatabase::RemoveVerifiedPairs.
Status RemoveVerifiedPairs(
    const std::filesystem::path& path,
    const std::vector<std::pair<uint32_t, uint32_t>>& pairs);

// Deletes a database and the files that SQLite keeps beside it, if they exist.
void RemoveDatabase(const std::filesystem::path& path);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MATCHING_MATCH_DATABASE_H_
